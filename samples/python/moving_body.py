"""A scanned body moves: moving_body.py [PAGE.html]. Simulates the sample body's somersault and writes its page."""
import sys

import numpy as np

import borelli

body = borelli.phantom(spacing=5)
scene = borelli.skeleton(body.table, body.landmarks)
motion = borelli.simulate(scene, accuracy=1e-6, output_interval=1 / 60)
print(motion.summary)

head = motion.positions[:, motion.solids.index("head")]
print(f"the head's path is {np.linalg.norm(np.diff(head, axis=0), axis=1).sum():.2f} m long")

# a hundred take-offs, each turning a little faster or slower
system = borelli.System(scene)
start = system.state()
v = np.tile(start.v, (100, 1)) * np.linspace(0.9, 1.1, 100)[:, np.newaxis]
ends = borelli.simulate_ensemble(system, v=v, duration=0.2, method="dop853", tolerance=1e-8)
print(f"{ends.trusted.sum()} of {len(ends.q)} motions are trusted")
if len(sys.argv) > 1:
    motion.write(sys.argv[1])
