(define (fib n) (if (< n 2) n (+ (fib (- n 1)) (fib (- n 2)))))
(define start (get-internal-run-time))
(unless (= (fib 30) 832040) (exit 1))
(display (/ (- (get-internal-run-time) start) (/ internal-time-units-per-second 1000.0)))
