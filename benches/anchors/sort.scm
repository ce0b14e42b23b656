(define numbers
  (let loop ((i 0) (x 42) (found '()))
    (if (= i 100000) found
        (let ((next (modulo (+ (* x 1103515245) 12345) 2147483648))) (loop (+ i 1) next (cons next found))))))
(define start (get-internal-run-time))
(unless (= (list-ref (sort numbers (lambda (a b) (< a b))) 50000) 1072443146) (exit 1))
(display (/ (- (get-internal-run-time) start) (/ internal-time-units-per-second 1000.0)))
