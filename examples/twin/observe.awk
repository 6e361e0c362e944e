# What three cameras see of the trajectory of a cloud: nodes that nothing hides, with noise and gaps. Every second one is
# a track, whose node is known; of the others every fourth is a point alone.
# Variables: nodes, noise (m), seed, tracks and points (files).
function uniform() { seed = (seed * 16807) % 2147483647; return seed / 2147483647 }
function normal() { return sqrt(-2 * log(uniform())) * cos(6.283185307179586 * uniform()) }
# Orthographic, in cells of 8 mm; what is farther back than 6 mm behind the nearest of its cell is hidden.
function look(camera,   i, turn, u, v, depth, cell) {
  turn = camera * 2.0943951023931953 + 0.3
  delete front
  for (i = 0; i < nodes; ++i) {
    u = -sin(turn) * x[i] + cos(turn) * y[i]
    v = -0.5 * (cos(turn) * x[i] + sin(turn) * y[i]) + 0.8660254 * z[i]
    depth[i] = -(0.8660254 * (cos(turn) * x[i] + sin(turn) * y[i]) + 0.5 * z[i])
    cell[i] = int(u / 0.008 + 1000) "," int(v / 0.008 + 1000)
    if (!(cell[i] in front) || depth[i] < front[cell[i]]) front[cell[i]] = depth[i]
  }
  for (i = 0; i < nodes; ++i) if (depth[i] < front[cell[i]] + 0.006) seen[i] = 1
}
function frame(   i, camera) {
  delete seen
  for (camera = 0; camera < 3; ++camera) look(camera)
  for (i = 0; i < nodes; ++i) {
    # A tracker loses a node for half a second, now and then.
    if (uniform() < 0.02) lost[i] = time + 0.5
    if (!(i in seen)) continue
    if (i % 2 == 0) {
      if (!(lost[i] > time)) printf "%s,%d,%.5f,%.5f,%.5f,%g\n", time, i, x[i] + noise * normal(), y[i] + noise * normal(), z[i] + noise * normal(), noise >tracks
    } else if (i % 8 == 1)
      printf "%s,%.5f,%.5f,%.5f,%g\n", time, x[i] + noise * normal(), y[i] + noise * normal(), z[i] + noise * normal(), noise >points
  }
}
BEGIN { FS = ","; print "time,node,x,y,z,s" >tracks; print "time,x,y,z,s" >points }
FNR > 1 {
  if ($1 != time && FNR > 2) frame()
  time = $1
  if ($2 < nodes) { x[$2] = $3; y[$2] = $4; z[$2] = $5 }
}
END { frame() }
