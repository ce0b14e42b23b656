(define (sum-to n) (let loop ((i 0) (sum 0)) (if (< i n) (loop (+ i 1) (+ sum i)) sum)))
(define start (get-internal-run-time))
(unless (= (sum-to 10000000) 49999995000000) (exit 1))
(display (/ (- (get-internal-run-time) start) (/ internal-time-units-per-second 1000.0)))
