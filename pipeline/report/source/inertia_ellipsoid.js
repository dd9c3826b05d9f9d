// The inertia of a selected part in the scene: the ellipsoid of the part's mass and principal moments about its gravity
// centre, and its principal axes, which extend beyond it by half of their length.
import {
  BufferGeometry,
  Group,
  Line,
  LineBasicMaterial,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  SphereGeometry,
  Vector3,
} from 'three';

export const axisColours = ['#d55e00', '#009e73', '#0072b2']; // of the smallest, middle and largest moment

/** Semi-axes (m) of the homogeneous ellipsoid with this mass (kg) and these principal moments (kg m²); null if there is none. */
export function semiAxes(mass, [a, b, c]) {
  const squares = [b + c - a, c + a - b, a + b - c].map((sum) => (2.5 * sum) / mass);
  return mass > 0 && squares.every((square) => square > 0) ? squares.map(Math.sqrt) : null;
}

/**
 * The ellipsoid and its axes as a child for the solid's node, or null. `inertia` = {mass, centre (m), moments (kg m²), axes:
 * rows of a matrix whose columns are the principal axes}, in the patient frame; `scan` = the solid's pose in that frame, as
 * 16 numbers by columns.
 */
export function makeEllipsoid(inertia, scan) {
  const radii = inertia && scan ? semiAxes(inertia.mass, inertia.moments) : null;
  if (!radii) return null;
  const columns = [0, 1, 2].map((column) => new Vector3(...inertia.axes.map((row) => row[column])));
  if (columns[0].clone().cross(columns[1]).dot(columns[2]) < 0) columns[2].negate();
  const group = new Group();
  group.matrixAutoUpdate = false;
  group.matrix
    .makeBasis(...columns)
    .setPosition(new Vector3(...inertia.centre))
    .premultiply(new Matrix4().fromArray(scan).invert());
  const skin = new Mesh(
    new SphereGeometry(1, 32, 20),
    new MeshBasicMaterial({ color: '#ffe14d', transparent: true, opacity: 0.35, depthTest: false }),
  );
  skin.scale.set(...radii);
  const wires = new Mesh(
    new SphereGeometry(1, 12, 8),
    new MeshBasicMaterial({ color: '#8a6d00', wireframe: true, transparent: true, opacity: 0.45, depthTest: false }),
  );
  wires.scale.copy(skin.scale);
  group.add(skin, wires);
  axisColours.forEach((colour, i) => {
    const end = new Vector3().setComponent(i, 1.5 * radii[i]);
    const line = new Line(
      new BufferGeometry().setFromPoints([end.clone().negate(), end]),
      new LineBasicMaterial({ color: colour, depthTest: false }),
    );
    group.add(line);
  });
  group.traverse((node) => {
    node.renderOrder = 2;
  });
  return group;
}
