#!/bin/sh
# A module that makes one mistake: the one that its argument names.
mode=$1
say() { printf '%s\n' "$1"; }
die() { echo "faulty: $mode" >&2; exit 3; }
greet() { say "{\"type\":\"hello\",\"protocol\":${1:-2},\"module\":\"${2:-faulty}\"}"; }
fluent() { say "{\"type\":\"fluents\",\"values\":{$1}}"; }
done_at() { say "{\"type\":\"done\",\"time_us\":$1}"; }

case $mode in
  death-before-hello) die ;;
  child-before-hello) sleep 100 & die ;;
  background-before-hello) sleep 100 & exit 0 ;;
  no-hello) echo "loading a large model" >&2; sleep 100 ;;
  not-hello-first) read -r line; fluent '"light*":1' ;;
  text-before-hello) echo "Loading weights..." ;;
  wrong-version) read -r line; greet 1 ;;
  wrong-name) read -r line; greet 2 lamp ;;
  floods-before-hello) yes '{}' ;;
esac
read -r line
greet
case $mode in
  death-after-hello) die ;;
  hello-twice) greet ;;
  done-without-tick) done_at 0 ;;
  closes-output) exec >&-; sleep 100 ;;
  closes-input) exec <&-; sleep 100 ;;
esac

fault() {
  case $mode in
    death-at-tick) die ;;
    killed) kill -9 $$ ;;
    child-at-tick) sleep 100 & die ;;
    child-and-killed) sleep 100 & kill -9 $$ ;;
    child-and-half-a-line) sleep 100 & printf '{"type":"flue'; die ;;
    half-a-line) printf '{"type":"flue'; die ;;
    half-a-line-and-alive) printf '{"type":"flue'; sleep 100 ;;
    long-line) head -c 10000000 /dev/zero | tr '\0' x; say '' ;;
    not-utf-8) printf '{"type":"\377"}\n' ;;
    not-json) say 'Traceback (most recent call last):' ;;
    empty-line) say '' ;;
    not-an-object) say '[1,2]' ;;
    unknown-type) say '{"type":"succes","id":1}' ;;
    no-type) say '{"id":1}' ;;
    missing-field) say '{"type":"success"}' ;;
    unknown-field) say '{"type":"success","id":1,"result":2}' ;;
    wrong-type) say '{"type":"success","id":"one"}' ;;
    negative-id) say '{"type":"success","id":-1}' ;;
    unknown-fluent) fluent '"lihgt*":0.5' ;;
    wrong-value) fluent '"light*":"bright"' ;;
    object-value) fluent '"light*":{"lux":3}' ;;
    fraction) fluent '"cups*":1.5' ;;
    beyond-64-bits) fluent '"cups*":9223372036854775808' ;;
    nan) fluent '"light*":NaN' ;;
    infinite) fluent '"light*":Infinity' ;;
    huge-number) fluent '"light*":1e400' ;;
    deep-list) fluent "\"seen*\":$(printf '%65s' | tr ' ' '[')$(printf '%65s' | tr ' ' ']')" ;;
    deeper-list) fluent "\"seen*\":$(printf '%5000s' | tr ' ' '[')$(printf '%5000s' | tr ' ' ']')" ;;
    odd-symbol) fluent '"seen*":[{"symbol":"two words"}]' ;;
    unknown-id) say '{"type":"success","id":7}' ;;
    success-twice) say "{\"type\":\"success\",\"id\":$id}"; say "{\"type\":\"success\",\"id\":$id}" ;;
    failure-after-success)
      say "{\"type\":\"success\",\"id\":$id}"
      say "{\"type\":\"failure\",\"id\":$id,\"class\":\"no-cup\",\"message\":\"none\"}" ;;
    odd-class) say "{\"type\":\"failure\",\"id\":$id,\"class\":\"no cup\",\"message\":\"none\"}" ;;
    done-twice) done_at "$time_us" ;;
    done-for-later) done_at 999999999 ;;
    never-done) sleep 100 ;;
    floods) yes '{"type":"fluents","values":{"light*":1}}' ;;
    floods-errors) yes 'warning: something is wrong' >&2 ;;
    hello-again) greet ;;
  esac
}

while read -r line; do
  case $line in
    *'"type":"start"'*)
      id=${line#*\"id\":}; id=${id%%,*}
      [ "$mode" = death-at-start ] && die
      [ "$mode" = no-cup ] && say "{\"type\":\"failure\",\"id\":$id,\"class\":\"No-Cup\",\"message\":\"there is none\",\"slots\":{\"place\":{\"symbol\":\"sink\"}}}"
      ;;
    *'"type":"stop"'*) [ "$mode" = death-at-stop ] && die ;;
    *'"type":"tick"'*)
      time_us=${line##*\"time_us\":}; time_us=${time_us%%[,\}]*}
      if [ -n "$id" ]; then fault; fi
      [ "$mode" = right ] && fluent '"light*":0.5,"cups*":2,"seen*":[{"symbol":"Cup"},"two words",[null,true]],"near*":"sink"'
      done_at "$time_us"
      if [ "$mode" = death-while-idle ] && [ -n "$id" ]; then die; fi
      ;;
    *'"type":"bye"'*)
      [ "$mode" = death-at-bye ] && die
      [ "$mode" = ignores-bye ] && sleep 100
      exit 0 ;;
  esac
done
