"""Accuracy against time: accuracy_against_time.py SCENE.toml [FOLDER]. Which method is fastest for an accuracy."""
import sys

import borelli

scene = borelli.read_model(sys.argv[1])
chart = borelli.chart(scene, methods=["rk4", "dopri5", "dop853", "gbs"], duration=2, budget=0.1, repeats=1)
print(chart.reference)
for take in chart.recommendations:
    print(f"for {take['error']:.0e}: {take['method']}, {1e3 * take['seconds']:.2f} ms")
print(chart.to_pandas().groupby("method")[["error", "seconds"]].min())
if len(sys.argv) > 2:
    chart.write(sys.argv[2])
