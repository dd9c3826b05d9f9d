// The measured ground forces as arrows in the player: 1 m for 1000 N, from the point where each acts.
import { ConeGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, Vector3 } from 'three';
import { sideColour } from './charts.js';
import { between, sideOf } from './efforts.js';

const metresPerNewton = 1e-3;
const least = 5; // N: a plate's noise has no direction
const up = new Vector3(0, 1, 0);
const inScene = ([x, y, z]) => new Vector3(x, z, -y); // the world is Z up, glTF Y up

const casing = 0.006; // m, outline of each part

/** One arrow along +Y from the origin. Nothing hides it, and a light outline separates it from the body's colours. */
function makeArrow() {
  const colour = new MeshBasicMaterial({ depthTest: false, transparent: true });
  const light = new MeshBasicMaterial({ color: 0xffffff, depthTest: false, transparent: true, opacity: 0.8 });
  const shaft = new CylinderGeometry(0.009, 0.009, 1, 12).translate(0, 0.5, 0);
  const head = new ConeGeometry(0.028, 1, 16).translate(0, 0.5, 0);
  const group = new Group();
  const part = (geometry, material, order, radial) => {
    const mesh = new Mesh(geometry, material);
    mesh.renderOrder = order; // outlines first
    mesh.scale.set(radial, 1, radial);
    group.add(mesh);
    return mesh;
  };
  const shafts = [part(shaft, light, 2, 1 + casing / 0.009), part(shaft, colour, 3, 1)];
  const heads = [part(head, light, 2, 1 + (2 * casing) / 0.028), part(head, colour, 3, 1)];
  return {
    group,
    colour: (value) => colour.color.set(value),
    aim(from, force) {
      const length = force.length() * metresPerNewton;
      const tip = Math.min(0.1, 0.4 * length);
      group.position.copy(from);
      group.quaternion.setFromUnitVectors(up, force.clone().normalize());
      for (const mesh of shafts) mesh.scale.y = length - tip;
      heads.forEach((mesh, i) => {
        const beyond = i === 0 ? casing : 0;
        mesh.position.y = length - tip - beyond;
        mesh.scale.y = tip + 4 * beyond;
      });
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
