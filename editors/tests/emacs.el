;;; A session of Emacs with the settings of docs/editors.md, over a copy of the project beside this file:
;;;   emacs --batch -Q -l editors/tests/emacs.el
;;; (28: with -q, for the package Eglot). It needs `rpl' in the path, and ends with the number of answers that were not
;;; as expected. Eglot shows no lenses, so it is offered none.

(require 'json)
(require 'cl-lib)
(when (< emacs-major-version 29) (package-initialize))
(require 'eglot)
(require 'flymake)
(require 'xref)

(defvar session-here (file-name-directory load-file-name))
(defvar session-failed 0)
(defvar session-asked 0)

;; The block of the page.
(with-temp-buffer
  (insert-file-contents (expand-file-name "../../docs/editors.md" session-here))
  (search-forward "## Emacs")
  (search-forward "```text\n")
  (let ((from (point)))
    (search-forward "\n```")
    (let ((settings (buffer-substring from (match-beginning 0))))
      (with-temp-buffer (insert settings) (eval-buffer)))))

(defvar session-project (file-name-as-directory (file-truename (make-temp-file "rpl" t))))
(dolist (file (directory-files (expand-file-name "project" session-here) t "^[^.]"))
  (copy-file file session-project))
;; What Eglot takes for a project is one of the version control.
(make-directory (expand-file-name ".git" session-project))

(defun session-check (name ok got)
  (setq session-asked (1+ session-asked))
  (unless ok
    (setq session-failed (1+ session-failed))
    (princ (format "%s: %S\n" name got))))

(defun session-wait (condition)
  (let ((until (+ (float-time) 20)) (found nil))
    (while (and (not (setq found (funcall condition))) (< (float-time) until))
      (accept-process-output nil 0.02))
    found))

(defun session-open (file)
  (switch-to-buffer (find-file-noselect (expand-file-name file session-project)))
  ;; In a terminal this comes with the first command.
  (unless (eglot-managed-p)
    (apply #'eglot--connect (eglot--guess-contact))
    (session-wait #'eglot-managed-p)))

(defun session-at (value path)
  (dolist (key (split-string path "\\." t) value)
    (setq value (cond ((vectorp value) (let ((at (string-to-number key))) (and (< at (length value)) (aref value at))))
                      ((listp value) (plist-get value (intern (concat ":" key))))))))

(defun session-is (want got op)
  (let ((want (if (eq want :null) nil want)))
    (pcase op
      ("is" (equal want got))
      ("has" (and (stringp got) (string-search want got)))
      ("count" (= (length got) want))
      ("more" (> (length got) want))
      ("some" (cl-some (lambda (one)
                         (equal (plist-get one (intern (concat ":" (aref want 0)))) (aref want 1)))
                       got)))))

(defun session-ask (method params)
  (condition-case failure
      (jsonrpc-request (eglot-current-server) (intern (concat ":" method)) params :timeout 20)
    (jsonrpc-error (list :error (format "%s" (or (alist-get 'jsonrpc-error-message (cddr failure)) failure))))))

(let ((requests (with-temp-buffer
                  (insert-file-contents (expand-file-name "requests.json" session-here))
                  (json-parse-buffer :object-type 'plist :null-object :null :false-object :json-false))))
  (seq-doseq (request (seq-remove (lambda (one) (string-suffix-p "codeLens" (plist-get one :method))) requests))
    (session-open (plist-get request :file))
    (let* ((uri (plist-get (eglot--TextDocumentIdentifier) :uri))
           (method (plist-get request :method))
           (params (copy-sequence (plist-get request :params))))
      (when (plist-get params :data) (setq params (plist-put params :data uri)))
      (when (string-prefix-p "textDocument" method)
        (setq params (plist-put params :textDocument (list :uri uri))))
      (when (plist-get request :word)
        (goto-char (point-min))
        (forward-line (plist-get request :line))
        (search-forward (plist-get request :word))
        (goto-char (+ (match-beginning 0) (or (plist-get request :offset) 1)))
        (setq params (plist-put params :position (eglot--pos-to-lsp-position))))
      (let ((answer (session-ask method params)))
        (seq-doseq (want (plist-get request :want))
          (let* ((path (aref want 0))
                 (got (if (equal path "changes.$uri")
                          (plist-get (session-at answer "changes") (intern (concat ":" uri)))
                        (session-at answer path))))
            (session-check (plist-get request :name) (session-is (aref want 2) got (aref want 1)) got)))))))

;; What a user does: by the commands of the editor.
(defun session-line (number)
  (save-excursion (goto-char (point-min)) (forward-line number)
                  (buffer-substring-no-properties (line-beginning-position) (line-end-position))))
(defun session-go (number word)
  (goto-char (point-min)) (forward-line number) (search-forward word) (goto-char (1+ (match-beginning 0))))

(session-open "main.rpl")
(session-check "the mode" (eq major-mode 'rpl-mode) major-mode)
(session-go 7 "go-to")
(let ((found (xref-backend-definitions 'eglot (xref-backend-identifier-at-point 'eglot))))
  (session-check "a definition of the library" (= (length found) 1) found)
  (save-window-excursion
    (xref-pop-to-location (car found))
    (session-check "it is opened" (looking-at-p "go-to (") (session-line (1- (line-number-at-pos))))
    (session-check "it is only read" buffer-read-only (buffer-name))))
(switch-to-buffer "main.rpl")
(session-check "symbols of the project"
               (cl-some (lambda (one) (string-search "round-trip" (format "%s" one)))
                        (xref-backend-apropos 'eglot "round"))
               "none")

(defun session-findings ()
  (flymake-start)
  (length (flymake-diagnostics)))
(session-wait (lambda () (eql 0 (session-findings))))
(session-go 19 "keep-count")
(delete-region (line-beginning-position) (line-end-position))
(insert "(print   (keep-cont 3))")
(eglot--signal-textDocument/didChange)
(session-check "findings after an edit" (session-wait (lambda () (= 1 (session-findings)))) (flymake-diagnostics))
(session-go 19 "keep-cont")
(let* ((actions (eglot-code-actions (point) (1+ (point)))) ; without a user they are handed back
       (mend (cl-find-if (lambda (one) (string-search "keep-count" (plist-get one :title))) actions)))
  (session-check "a finding can be mended" mend actions)
  (when mend
    (eglot--apply-workspace-edit (plist-get mend :edit) (if (> emacs-major-version 28) 'session nil)))
  (session-check "it is mended" (string-search "keep-count" (session-line 19)) (session-line 19)))
(eglot--signal-textDocument/didChange)
(session-check "no findings after it" (session-wait (lambda () (= 0 (session-findings)))) (flymake-diagnostics))
(eglot-format-buffer)
(session-check "the text is laid out" (equal (session-line 19) "(print (keep-count 3))") (session-line 19))
(session-go 12 "count")
(eglot-rename "number")
(session-check "a variable is renamed" (equal (session-line 14) "      (incf number))") (session-line 14))
(session-check "the outline" (string-search "\"inspect\"" (format "%S" (imenu--make-index-alist t))) imenu--index-alist)
(save-buffer)

(princ (format "Emacs %s: %d of %d as expected\n" emacs-version (- session-asked session-failed) session-asked))
(kill-emacs (min session-failed 100))
