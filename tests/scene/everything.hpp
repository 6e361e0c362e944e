// Two scenes that together use every key there is: they show that the reader takes each of them.
#pragma once

inline const char* const everything = R"(
version = 1
title = "everything"

[simulation]
duration = 2.5
time_step = 0.02
integrator = { name = "recurrent", update = "synchronous", max_sweeps = 77 }
threads = 2
instruction_set = "generic"
renumber = false

[gravity]
acceleration = [0, 0, -9.81]

[output]
interval = 0.1
trajectory = false
reactions = true
surfaces = false
rigid = false
contacts = false
elements = false
energies = true
states = false
nodes = { body = "chain" }
springs = { body = "block", springs = [0, 5] }
quantities = ["force", "position"]
format = "binary"
precision = "single"
vtk = true
vtk_interval = 0.5
view = false
view_size = 1e7

[[body]]                      # nodes 0 to 7, springs 0 to 11
name = "block"
mesh = { lattice = [2, 2, 2], spacing = [1.0, 2.0, 3], origin = [0, 0, 5], diagonals = "none" }
velocity = [0, 0, -1]
neuron = { type = "point_mass", mass = 2.0 }
spring = { type = "linear", stiffness = 3.0 }
viscosity = { type = "power", damping = 2.0, exponent = 1.5 }
rest_length_scale = 0.5
surface_thickness = 0.01
radius = 0.02

[[body]]                      # nodes 8 to 10, springs 12 and 13
name = "chain"
nodes = [[10, 0, 0], [11, 0, 0], [13, 0, 0]]
springs = [[0, 1], [1, 2]]
neuron = { type = "dragged", mass = 1.0, drag = 0.5 }
viscosity = { type = "relative", damping = 1.0 }

[[connect]]                   # spring 14
pairs = [[{ body = "block", node = 1 }, { body = "chain", node = 0 }]]
spring = { type = "rupturing", stiffness = 5.0, strength = 2.0, breaks_in_compression = true }
viscosity = { type = "linear", damping = 1.0 }
rest_length = 4.5

[[connect]]                   # spring 15: nodes 7 and 8 are nearer to one another than any others
from = { body = "block", nodes = [7] }
to = { body = "chain" }
nearest = true
spring = { type = "linear", stiffness = 5.0 }
rest_length_scale = 2.0

[[connect]]                   # spring 16: nodes 8 and 10
from = { nodes = [8] }
to = { nodes = [10] }
within = 3.0
spring = { type = "linear", stiffness = 5.0 }

[[rigid]]                     # 8 and 9
pairs = [[{ body = "chain", node = 0 }, { body = "chain", node = 1 }]]
length = 1.0

[[rigid]]                     # 0 and 1: of nodes 0 to 2 only these two are that near
from = { nodes = [0] }
to = { nodes = [1, 2] }
within = 1.5

[[rigid]]                     # 2 and 3
from = { nodes = [2] }
to = { body = "block", nodes = [3, 7] }
nearest = true

[[rigid]]                     # 9 and 10
springs = { body = "chain", springs = [1] }

[[node]]
select = { body = ["block", "chain"], box = { min = [0, 0, 8], max = [1, 0, 8] } }   # 4 and 5
mass = 4.0
velocity = [1, 2, 3]
neuron = { type = "dragged", drag = 0.25 }

[[spring]]
select = { springs = [0] }
spring = { type = "nonlinear", stiffness = 1.0, cubic = 2.0 }
viscosity = "none"
rest_length = 0.75

[[spring]]
select = { body = "chain", springs = [0] }
spring = { type = "linear", stiffness = 7.0 }
viscosity = { type = "linear", damping = 7.0 }
rest_length_scale = 3.0

[[fix]]
select = { sphere = { center = [13, 0, 0], radius = 0.5 } }                           # 10

[[force]]
select = { nodes = [3] }
force = [1, 0, 0]
from = 0.5
until = 1.5

[[force]]
select = { body = "block" }
total = [0, 0, 8]
share = "nodes"
table = [[0, 0], [1, 1.5]]
interpolation = "linear"

[[force]]
select = { body = "block" }
traction = [0, 1, 0]
sinusoid = { frequency = 2.0, phase = 0.5, amplitude = 0.25, mean = 1.0 }

[[force]]
select = { body = "block" }
pressure = 2.0
follow = true
ramp = 0.5

[[move]]
select = { nodes = [0, 1] }
table = [[0, 0, 0, 0], [1, 0, 0, 0.5], [2.5, -1, 0, 0.5]]
interpolation = "linear"

[[move]]
select = { nodes = [6] }
sinusoid = { amplitude = [0, 0.1, 0], frequency = 2.5, phase = 0.5 }
from = 0.25
until = 2.25

[[contact]]
name = "apart"
between = [{ body = "block" }]
friction = 0.25
restitution = 0.5

[[plane]]
name = "floor"
point = [0, 0, -1]
normal = [0, 0, 2]
friction = 0.3
motion = { table = [[0, 0, 0, 0], [1, 0, 0, 0.25]], interpolation = "smooth" }
turn = { axis = [0, 0, 2], rate = -0.5, from = 0.25, until = 2.0 }
restitution = 0.75

[[instrument]]
name = "ball"
sphere = { center = [5, 5, 5], radius = 0.5 }
friction = "none"
motion = { sinusoid = { amplitude = [1, 0, 0], frequency = 0.5, phase = 1.5 }, from = 0.5, until = 1.5 }

[[instrument]]
name = "probe"
capsule = { from = [0, 0, 20], to = [0, 0, 30], radius = 0.25 }
restitution = 0.5

[[instrument]]
name = "slab"
box = { center = [0, 20, 0], size = [1, 2, 3], rotation = { axis = [0, 0, 3], angle = 0.5 }, radius = 0.125 }
turn = { axis = [0, 1, 0], through = [0, 19, 0], table = [[0, 0], [1, 1.5]], interpolation = "linear" }

[[cut]]
time = 1.0
select = { springs = [3] }

[[cut]]
time = 2.0
polygon = [[0.5, -1, 0], [0.5, 5, 0], [0.5, 5, 9]]

[[change]]
time = 1.5
select = { springs = [1] }
spring = { stiffness = 5.0 }
viscosity = { exponent = 1.25 }
rest_length = 1.0

[[change]]
time = 1.6
select = { springs = [2] }
rest_length_scale = 2.0

[[change]]
time = 1.7
select = { nodes = [9] }
neuron = { drag = 0.75 }
mass = 3.0

[[change]]
time = 1.8
select = { springs = [4] }
remove = "springs"

[[change]]
time = 2.0
integrator = { name = "verlet", substeps = 2 }
)";

// Meshes, materials and elements.
inline const char* const everything_of_meshes = R"(
rules = "rules.fcl"

[simulation]
duration = 1.0
time_step = 0.01

[[body]]
name = "bar"
mesh = { file = "bar.msh", start = "bar.msh", scale = 0.001, rotation = { axis = [0, 0, 2], angle = 0.5 }, origin = [0, 0, 40] }
neuron = { type = "point_mass" }
density = 1000.0
thickness = 0.001
cross_section = 1e-6
material = { youngs_modulus = 1e4, poisson_ratio = 0.45, damping_time = 0.01, law = { type = "nonlinear", cubic = 2 } }

[[body]]
name = "chain"
nodes = [[10, 0, 0], [11, 0, 0], [13, 1, 0]]
springs = [[0, 1], [1, 2]]
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "table", elongations = { file = "curve.csv", column = "elongation" }, forces = [-1, 0, 2, 5] }

[[element]]
name = "filling"
invariant = "enclosed_volume"
select = { body = "bar", group = "skin" }
spring = { type = "linear", stiffness = 1e9 }
viscosity = { type = "linear", damping = 1e3 }
reference_scale = 1.1

[[element]]
invariant = "angle"
body = "chain"
nodes = [[0, 1, 2]]
spring = { type = "linear", stiffness = 0.1 }
reference = 3.0
values = "element_values.csv"

[[spring]]
values = "spring_values.csv"

[[fix]]
select = { group = ["left", "right"] }

[[body]]
name = "toy"
mesh = { points = "cloud.csv", radius = 1.5, neighbours = 4 }
mass = 0.5
neuron = { type = "point_mass" }
spring = { type = "linear", stiffness = 100.0 }

[[move]]
tracks = "tracks.csv"
body = "toy"

[[body]]
name = "arm"
nodes = [[20, 0, 0], [21, 0, 0]]
springs = [[0, 1]]
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "muscle", strength = 10.0 }

[[body]]
name = "fibres"
mesh = { lattice = [2, 2, 3], spacing = 1.0, origin = [30, 0, 0] }
neuron = { type = "point_mass" }
density = 1000.0
material = { youngs_modulus = 1e4, poisson_ratio = 0.45, damping_time = 0.01, direction = [0, 0, 1], law = { type = "fibre_solid", fibre_modulus = 1e5 } }

[[body]]
name = "skin"
mesh = { lattice = [3, 3, 1], spacing = 1.0, origin = [40, 0, 0] }
neuron = { type = "point_mass" }
density = 1000.0
thickness = 0.001
material = { youngs_modulus = 1e4, poisson_ratio = 0.3, bending = true, law = { type = "membrane", model = "st_venant_kirchhoff" } }

[[element]]
invariant = "tetrahedron"
select = { body = "fibres" }
direction = [1, 0, 0]
spring = { type = "fibre_solid", youngs_modulus = 1.0, poisson_ratio = 0.3, fibre_modulus = 1.0 }

[[change]]
time = 0.25
elements = ["filling"]
reference_scale = 1.25
viscosity_inputs = {}

[[change]]
time = 0.5
elements = ["filling"]
reference = 0.5

[[change]]
time = 0.75
select = { body = "arm" }
inputs = { activation = 0.5 }

[[input]]
input = "activation"
name = "left"
select = { body = "arm" }
elements = ["filling"]
times = [0, 0.5, 1]
values = [0, 1, 0.25]
interpolation = "cubic"

[[input]]
input = "activation"
file = "activation.csv"
column = "activation"

[[input]]
input = "activation"
sinusoid = { frequency = 2.0, amplitude = 0.25, mean = 0.5, phase = 0.1 }

[[input]]
input = "activation"
value = 0.5

# Lists with a value for each of what they list.
[[body]]
name = "lists"
nodes = [[50, 0, 0], [51, 0, 0], [50, 1, 0], [50, 0, 1]]
springs = [[0, 1], [0, 2]]
rest_lengths = [1.0, 0.9]
masses = [1, 2, 3, 4]
velocities = [[0, 0, 1], [0, 0, 2], [0, 0, 3], [0, 0, 4]]
faces = [[0, 1, 2]]
groups = [{ name = "end", nodes = [1] }]
neuron = { type = "point_mass" }
spring = { type = "linear", stiffness = 1.0 }

[[connect]]
pairs = [[{ body = "lists", node = 0 }, { body = "lists", node = 3 }]]
rest_lengths = [1.1]
spring = { type = "linear", stiffness = 1.0 }

[[rigid]]
pairs = [[{ body = "lists", node = 0 }, { body = "lists", node = 3 }]]
lengths = [1.0]

[[element]]
invariant = "area"
body = "lists"
nodes = [[0, 1, 2]]
spring = { type = "linear", stiffness = 1.0 }
references = [0.4]

[[element]]
invariant = "tetrahedron"
body = "lists"
nodes = [[0, 1, 2, 3]]
rests = [[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.1]]]
directions = [[0, 0, 2]]
spring = { type = "fibre_solid", youngs_modulus = 1.0, poisson_ratio = 0.3, fibre_modulus = 1.0 }

[[force]]
faces = [[0, 1, 2]]
areas = [[0, 0, 0.5]]
pressure = 1.0

[[instrument]]
box = { center = [0, 200, 0], size = [1, 2, 3], axes = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] }
)";
