import sys
N=int(sys.argv[1]); F=float(sys.argv[2]); k=float(sys.argv[3]); mu=float(sys.argv[4]); freq=float(sys.argv[5]); waves=float(sys.argv[6]); update=sys.argv[7]; dur=sys.argv[8]
import math
a=0.02
pairs=[]
n=lambda i,j,kk: i+(N+1)*(j+2*kk)
s=f'''title = "A worm crawls by waves of its muscles"

[simulation]
duration   = {dur}
time_step  = 0.005            # s
integrator = {update}

[gravity]
acceleration = [0, 0, -9.81]  # m/s^2

[output]
interval = 0.05               # s

[[body]]
name      = "worm"
mesh      = {{ lattice = [{N+1}, 2, 2], spacing = {a}, diagonals = "all" }}
neuron    = {{ type = "point_mass", mass = 2e-4 }}
spring    = {{ type = "linear", stiffness = {k} }}
viscosity = {{ type = "linear", damping = 0.01 }}

[[plane]]
name     = "floor"
point    = [0, 0, 0]
normal   = [0, 0, 1]
friction = {mu}
'''
pl=[f'[{{ body = "worm", node = {n(i,j,kk)} }}, {{ body = "worm", node = {n(i+1,j,kk)} }}]' for i in range(N) for j in (0,1) for kk in (0,1)]
s+='\n[[connect]]\npairs = [\n  '+',\n  '.join(pl)+'\n]\nspring = { type = "muscle", strength = %g, maximum_speed = 5.0 }\n'%F
for i in range(N):
    s+=f'''
[[input]]
input    = "activation"
select   = {{ box = {{ min = [{(i-0.1)*a:.4g}, -inf, -inf], max = [{(i+1.1)*a:.4g}, inf, inf] }} }}
sinusoid = {{ frequency = {freq}, amplitude = 0.5, mean = 0.5, phase = {-2*math.pi*waves*i/N:.4f} }}
'''
print(s)
