;; What a person does in Emacs, written down as JSON for tests/cli/test_editors.py.
;; Started as: emacs --batch -l CONFIGURATION -l emacs.el PROGRAM OUTPUT
(require 'eglot)
(require 'json)
(require 'cl-lib)

(defun await (what is-there)
  "Wait until IS-THERE returns a value, and return that; WHAT is named where it does not come."
  (let ((until (+ (float-time) 60)) value)
    (while (not (setq value (funcall is-there)))
      (when (> (float-time) until) (error "Not seen in time: %s" what))
      (accept-process-output nil 0.05))
    value))

(defun list-diagnostics ()
  (flymake-start)
  (mapcar (lambda (one)
            (list (cons 'line (line-number-at-pos (flymake-diagnostic-beg one)))
                  (cons 'word (buffer-substring-no-properties (flymake-diagnostic-beg one) (flymake-diagnostic-end one)))
                  (cons 'text (flymake-diagnostic-text one))))
          (flymake-diagnostics)))

(defun list-names (items)
  "The names in a tree of symbols, kinds among them."
  (cl-loop for (name . inside) in items
           collect (substring-no-properties name)
           when (listp inside) append (list-names inside)))

(let ((program (pop command-line-args-left)) (output (pop command-line-args-left)) seen)
  (find-file program)
  (push (cons 'mode (symbol-name major-mode)) seen)
  (run-hooks 'post-command-hook) ; eglot-ensure starts the server after the command
  (await "server" #'eglot-current-server)
  (push (cons 'diagnostics (vconcat (await "diagnostics" #'list-diagnostics))) seen)
  (goto-char (point-min))
  (search-forward "A101")
  (let (shown)
    (eglot-hover-eldoc-function (lambda (text &rest _) (setq shown (substring-no-properties text))))
    (push (cons 'hover (await "hover" (lambda () shown))) seen))
  (push (cons 'symbols (vconcat (list-names (eglot-imenu)))) seen)
  (cl-letf (((symbol-function 'completing-read) (lambda (_prompt all &rest _) (caar all)))
            ((symbol-function 'y-or-n-p) (lambda (&rest _) t)))
    (let ((last-nonmenu-event t)) ; not from a menu of the mouse
      (call-interactively #'eglot-code-actions)))
  (eglot--signal-textDocument/didChange) ; else after half a second without keys, which a batch has none of
  (await "no diagnostics after the quick fix" (lambda () (null (list-diagnostics))))
  (push (cons 'mended (buffer-string)) seen)
  (search-forward "P100")
  (xref-find-definitions (xref-backend-identifier-at-point (xref-find-backend)))
  (push (cons 'definition (line-number-at-pos)) seen)
  (eglot-shutdown (eglot-current-server))
  (with-temp-file output (insert (json-encode seen))))
