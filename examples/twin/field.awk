# Stiffnesses that differ from place to place: log-normal, a Gaussian field of random waves at the middles of springs.
# Reads what `springnet inspect --springs` writes. Variables: waves, correlation (m), median (N/m), factor (of one
# standard deviation), nodes (springs of others are left out), seed.
function uniform() { seed = (seed * 16807) % 2147483647; return seed / 2147483647 }
function normal() { return sqrt(-2 * log(uniform())) * cos(6.283185307179586 * uniform()) }
BEGIN {
  FS = ","
  for (i = 0; i < waves; ++i) {
    a[i] = normal() / correlation
    b[i] = normal() / correlation
    c[i] = normal() / correlation
    phase[i] = 6.283185307179586 * uniform()
  }
}
FNR > 1 && $2 < nodes && $3 < nodes {
  z = 0
  for (i = 0; i < waves; ++i) z += cos(a[i] * $4 + b[i] * $5 + c[i] * $6 + phase[i])
  field[n++] = z
  sum += z
  square += z * z
}
END {
  mean = sum / n
  width = sqrt(square / n - mean * mean)
  print "spring,spring.stiffness"
  for (s = 0; s < n; ++s) printf "%d,%.5g\n", s, median * exp(log(factor) * (field[s] - mean) / width)
}
