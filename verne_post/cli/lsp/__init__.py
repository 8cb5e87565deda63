"""`verne-post lsp`: a language server for programs."""
