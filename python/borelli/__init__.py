"""borelli: from a CT or MR volume of a person to body parts, inertia, a scene and its motion.

    volume = borelli.read_volume("scan.nii.gz", quantity="hu")
    found = borelli.segment(volume)
    table = borelli.inertia(volume, found)
    scene = borelli.skeleton(table, found.landmarks)
    motion = borelli.simulate(scene, duration=1, accuracy=1e-6)

Arrays are views of borelli's memory and keep it alive. Frames: volumes, landmarks and tables are in the patient's axes
(LPS: left, posterior, superior), grids and landmarks in mm; scenes are in their world, SI units. Names end in their unit
where it is another. What cannot be done raises Error; what is doubtful is a DoubtWarning. Long calls release the GIL.
"""
from ._core import (
    Chart,
    Derivatives,
    DoubtWarning,
    Ensemble,
    Error,
    Evaluation,
    InverseDynamics,
    Labels,
    Landmark,
    Phantom,
    Row,
    Scene,
    Segmentation,
    State,
    System,
    Table,
    Trajectory,
    Volume,
    __version__,
    accelerations,
    chart,
    inertia,
    inverse_dynamics,
    methods,
    phantom,
    read_labels,
    read_landmarks,
    read_model,
    read_table,
    read_trajectory,
    read_volume,
    segment,
    set_memory_limit,
    set_threads,
    simulate,
    simulate_ensemble,
    skeleton,
    write_landmarks,
)

__all__ = [name for name in dir() if not name.startswith("_")]
