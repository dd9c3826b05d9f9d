// The measured ground forces as arrows in the player: 1 m for 1000 N, from the point where each acts.
import { ConeGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, Vector3 } from 'three';
import { sideColour } from './charts.js';
import { between, sideOf } from './efforts.js';

const metresPerNewton = 1e-3;
const least = 5; // N: a plate's noise has no direction
const up = new Vector3(0, 1, 0);
const inScene = ([x, y, z]) => new Vector3(x, z, -y); // the world is Z up, glTF Y up

/** One arrow along +Y from the origin, faint where the body hides it. */
function makeArrow() {
  const shaft = new CylinderGeometry(0.008, 0.008, 1, 12).translate(0, 0.5, 0);
  const head = new ConeGeometry(0.024, 1, 16).translate(0, -0.5, 0);
  const seen = new MeshBasicMaterial();
  const hidden = new MeshBasicMaterial({ transparent: true, opacity: 0.45, depthTest: false });
  const shafts = [new Mesh(shaft, hidden), new Mesh(shaft, seen)];
  const heads = [new Mesh(head, hidden), new Mesh(head, seen)];
  const group = new Group();
  group.add(...shafts, ...heads);
  return {
    group,
    colour(value) {
      seen.color.set(value);
      hidden.color.set(value);
    },
    aim(from, force) {
      const length = force.length() * metresPerNewton;
      const tip = Math.min(0.09, 0.4 * length);
      group.position.copy(from);
      group.quaternion.setFromUnitVectors(up, force.clone().normalize());
      for (const mesh of shafts) mesh.scale.y = length - tip;
      for (const mesh of heads) {
        mesh.position.y = length;
        mesh.scale.y = tip;
      }
    },
  };
}

/** Arrows of `forces` [{solid, force, point}] at `times`; the player's time 0 is `origin`. */
export function makeForceArrows({ times, forces, origin }) {
  const group = new Group();
  const arrows = forces.map(({ solid, force, point }) => {
    const arrow = makeArrow();
    group.add(arrow.group);
    return { ...arrow, side: sideOf(solid), force, point };
  });
  const colour = () => arrows.forEach((arrow) => arrow.colour(sideColour(arrow.side)));
  colour();
  return {
    group,
    colour,
    mark(time) {
      const [i, share] = between(times, origin + time);
      const next = Math.min(i + 1, times.length - 1);
      for (const { group: drawn, aim, force, point } of arrows) {
        const [from, to] = [point[i], point[next]];
        drawn.visible = Boolean(from && to);
        if (!drawn.visible) continue;
        const now = inScene(force[i]).lerp(inScene(force[next]), share);
        drawn.visible = now.length() > least;
        if (drawn.visible) aim(inScene(from).lerp(inScene(to), share), now);
      }
    },
  };
}
