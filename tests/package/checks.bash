# Functions of the checks in this folder. Sourced after `set -euo pipefail`.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
checks=0

wrong() {
  echo "wrong: $*" >&2
  exit 1
}

# near WHAT VALUE EXPECTED TOLERANCE, absolute.
near() {
  awk -v value="$2" -v expected="$3" -v tolerance="$4" 'BEGIN {
    difference = value - expected
    if (difference < 0) difference = -difference
    exit !(value ~ /^[-+.0-9]/ && difference <= tolerance)
  }' || wrong "$1 is $2, not $3 within $4"
  checks=$((checks + 1))
}

# between WHAT VALUE SMALLEST LARGEST
between() {
  awk -v value="$2" -v smallest="$3" -v largest="$4" \
    'BEGIN {exit !(value ~ /^[-+.0-9]/ && value + 0 >= smallest && value + 0 <= largest)}' ||
    wrong "$1 is $2, not between $3 and $4"
  checks=$((checks + 1))
}

finish() { echo "$checks quantities as expected"; }
