"""Writes a case as PhysTwin's data have it: a block that a hand lifts, 8 frames; with `hostile` a pickle that runs a program."""
import json
import pathlib
import pickle
import sys

import numpy

folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True)
block = numpy.array([[x, y, z] for x in range(6) for y in range(4) for z in range(3)], float) * 0.012
block[:, 2] = -block[:, 2] - 0.001  # up is -z
frames = 8
points = numpy.repeat(block[None], frames, 0)
hand = numpy.repeat(numpy.array([[[0.06, 0.018, -0.02], [0.06, 0.0, -0.02]]]), frames, 0)
for k in range(frames):
    points[k, :, 2] -= 0.002 * k
    hand[k, :, 2] -= 0.002 * k
visible = numpy.ones(points.shape[:2], bool)
visible[:, ::5] = False
followed = numpy.ones(points.shape[:2], bool)
followed[3:, 1] = False  # from the fourth frame on
data = dict(object_points=points, object_colors=points, object_visibilities=visible, object_motions_valid=followed,
            controller_points=hand, surface_points=numpy.zeros((0, 3)), interior_points=block[:3] + [0.004, 0.004, 0.005])


class Program:
    def __reduce__(self):
        return (pathlib.Path.touch, (folder / "was_run",))


if len(sys.argv) > 2:
    data["object_colors"] = Program()
with open(folder / "final_data.pkl", "wb") as out:
    pickle.dump(data, out)
(folder / "metadata.json").write_text(json.dumps({"fps": 30, "frame_num": frames}))
