"""Machine files: TOML -> Machine. Every error names file, key, value and bound."""

from verne_post.config.load import load_machine, machine_files, validate_machine

__all__ = ["load_machine", "machine_files", "validate_machine"]
