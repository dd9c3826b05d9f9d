"""How much faster two Python threads simulate than one: python_threads.py SCENE.toml (samples/double_pendulum.toml).

The GIL is released, so on two idle cores the ratio is near 2.
"""
import sys
import threading
import time

import borelli

system = borelli.System(borelli.read_model(sys.argv[1]))


def simulate(runs):
    for _ in range(runs):
        borelli.simulate(system, method="rk4", step=1e-5, duration=1, output_interval=1)


def seconds(threads, runs):
    team = [threading.Thread(target=simulate, args=(runs // threads,)) for _ in range(threads)]
    began = time.perf_counter()
    for thread in team:
        thread.start()
    for thread in team:
        thread.join()
    return time.perf_counter() - began


simulate(1)
ratios = sorted(seconds(1, 6) / seconds(2, 6) for _ in range(5))
print(f"two threads are {ratios[2]:.2f} times as fast as one (median of 5; {ratios[0]:.2f} to {ratios[-1]:.2f})")
