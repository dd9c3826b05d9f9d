// The player's scene: the body of body.glb, its path, the ground, the lights and the camera.
import {
  AmbientLight,
  AnimationMixer,
  AxesHelper,
  Box3,
  BufferGeometry,
  CircleGeometry,
  Color,
  DirectionalLight,
  GridHelper,
  Group,
  HemisphereLight,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  PCFShadowMap,
  PerspectiveCamera,
  Scene,
  ShadowMaterial,
  SphereGeometry,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { css } from './dom.js';
import { makeForceArrows } from './force_arrows.js';

export const views = {
  // direction from the body to the camera; the patient faces +Z, the left hand is at +X
  'Three-quarter': [-0.55, 0.22, 1],
  Front: [0, 0.02, 1],
  Side: [1, 0.02, 0.001],
  Above: [0, 1, 0.02],
};

/** Scene, camera and renderer; draws only when something changed. `loads`: see makeForceArrows, or null. */
export async function makeBody(canvas, glb, centrePath, loads) {
  const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  const scene = new Scene();
  const camera = new PerspectiveCamera(28, 1, 0.01, 200);
  const orbit = new OrbitControls(camera, canvas);
  // the wheel scrolls the page; it zooms only with Ctrl or after a click or tab into the picture
  orbit.enableZoom = false;
  canvas.addEventListener('focus', () => {
    orbit.enableZoom = true;
  });
  canvas.addEventListener('blur', () => {
    orbit.enableZoom = false;
  });
  canvas.addEventListener(
    'wheel',
    (event) => {
      orbit.enableZoom = event.ctrlKey || document.activeElement === canvas;
    },
    { capture: true, passive: true },
  );
  canvas.style.touchAction = 'pan-y';
  const { scene: model, animations } = await new GLTFLoader().parseAsync(glb.buffer, '');
  scene.add(model);
  const solids = [];
  model.traverse((node) => {
    if (!node.isMesh) return;
    node.castShadow = true;
    node.geometry.computeBoundingSphere();
    solids.push(node);
  });
  const frames = solids.map((solid) => makeFrame(solid));

  const mixer = new AnimationMixer(model);
  const clip = animations[0];
  const duration = clip ? clip.duration : 0;
  const action = clip ? mixer.clipAction(clip) : null;
  action?.play();
  const pose = (time) => {
    if (!action) return;
    action.time = Math.min(Math.max(time, 0), duration); // mixer.setTime would wrap the last instant to the first
    mixer.update(0);
  };

  const travel = measure(model, solids, duration, pose);
  // forces were measured on a floor at height 0; else the body's lowest point is the floor
  const ground = makeGround(travel, loads ? 0 : travel.box.min.y);
  const sun = addLights(scene, travel);
  const path = centrePath ? makePath(centrePath, travel.size) : null;
  const arrows = loads ? makeForceArrows(loads) : null;
  scene.add(ground.group, ...[path, arrows].filter(Boolean).map(({ group }) => group));

  let asked = false;
  // the camera follows a body whose whole path would make it small in the picture
  let follow = travel.box.getSize(new Vector3()).length() > 1.2 * travel.size;
  let centre = travel.start.clone();
  const draw = () => {
    asked = false;
    renderer.render(scene, camera);
  };
  const ask = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(draw);
  };
  const keepInView = () => {
    if (!follow) return;
    const now = middle(solids);
    camera.position.add(now).sub(centre);
    orbit.target.add(now).sub(centre);
    centre = now;
  };
  const look = (name) => {
    centre = middle(solids);
    const target = follow ? centre.clone() : travel.box.getCenter(new Vector3());
    const spheres = follow ? travel.around.map((sphere) => sphere.clone().translate(centre)) : travel.spheres;
    const direction = new Vector3(...views[name]).normalize();
    const distance = 1.05 * distanceToSee(spheres, target, direction, camera);
    orbit.target.copy(target);
    camera.position.copy(target).addScaledVector(direction, distance);
    camera.near = distance / 100;
    camera.far = distance * 20 + travel.size * 10;
    camera.updateProjectionMatrix();
    orbit.update();
    ask();
  };
  orbit.addEventListener('change', ask);

  const self = {
    solids,
    duration,
    ground,
    path,
    arrows,
    frames,
    camera,
    orbit,
    look,
    ask,
    pose(time) {
      pose(time);
      keepInView();
      path?.mark(time);
      arrows?.mark(time);
      sun.follow(middle(solids));
    },
    drawNow: draw,
    follows: () => follow,
    setFollow(on) {
      follow = on;
      look('Three-quarter');
    },
    resize() {
      const { clientWidth: width, clientHeight: height } = canvas.parentElement;
      const fresh = camera.userData.fitted !== true;
      renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      if (fresh && width > 0) {
        camera.userData.fitted = true;
        look('Three-quarter');
      }
      draw();
    },
    colour() {
      ground.colour();
      path?.colour();
      arrows?.colour();
      ask();
    },
  };
  self.pose(0);
  return self;
}

/** The solid's frame, at the joint to its parent: x red, y green, z blue. */
function makeFrame(solid) {
  const frame = new AxesHelper(0.5 * solid.geometry.boundingSphere.radius);
  frame.material.depthTest = false;
  frame.renderOrder = 2;
  frame.visible = false;
  solid.add(frame);
  return frame;
}

const middle = (solids) => {
  const box = new Box3();
  for (const solid of solids)
    box.expandByPoint(solid.localToWorld(solid.geometry.boundingSphere.center.clone()));
  return box.getCenter(new Vector3());
};

/** Distance from `target` at which a camera that looks along -direction sees all these spheres. */
function distanceToSee(spheres, target, direction, camera) {
  const right = new Vector3(0, 1, 0).cross(direction).normalize();
  const up = direction.clone().cross(right);
  const tall = Math.tan((camera.fov / 2) * (Math.PI / 180));
  const wide = tall * camera.aspect;
  const reach = (offset, radius, slope) => (Math.abs(offset) + radius * Math.hypot(1, slope)) / slope;
  return Math.max(
    ...spheres.map(({ center, radius }) => {
      const at = center.clone().sub(target);
      return (
        at.dot(direction) + Math.max(reach(at.dot(up), radius, tall), reach(at.dot(right), radius, wide))
      );
    }),
  );
}

/** The gravity centre's path as a line, and a ball at its current position. */
function makePath({ times, points }, size) {
  const there = points.map(([x, y, z]) => new Vector3(x, z, -y)); // the world is Z up, glTF Y up
  const material = new LineBasicMaterial({ transparent: true, opacity: 0.8 });
  const ball = new Mesh(new SphereGeometry(0.01 * size, 20, 14), new MeshBasicMaterial());
  ball.material.depthTest = false; // it lies inside the body
  ball.renderOrder = 1;
  const group = new Group();
  group.add(new Line(new BufferGeometry().setFromPoints(there), material), ball);
  const colour = () => {
    material.color.set(css('--bad'));
    ball.material.color.set(css('--bad'));
  };
  colour();
  return {
    group,
    colour,
    mark(time) {
      const to = times.findIndex((t) => t - times[0] >= time);
      if (to <= 0) return void ball.position.copy(there[to < 0 ? there.length - 1 : 0]);
      const share = (time - (times[to - 1] - times[0])) / (times[to] - times[to - 1] || 1);
      ball.position.lerpVectors(there[to - 1], there[to], share);
    },
  };
}

/**
 * The space of the motion: the box and the spheres that contain all of it, the spheres relative to the body's middle
 * at their time, and the body's middle and size at the start.
 */
function measure(model, solids, duration, pose) {
  const box = new Box3();
  const all = new Box3();
  const spheres = [];
  const around = [];
  let start = null;
  let size = 0;
  const samples = duration > 0 ? 24 : 0;
  for (let i = 0; i <= samples; ++i) {
    pose(samples ? (duration * i) / samples : 0);
    model.updateMatrixWorld(true);
    box.setFromObject(model);
    all.union(box);
    const now = middle(solids);
    for (const solid of solids) {
      const sphere = solid.geometry.boundingSphere.clone().applyMatrix4(solid.matrixWorld);
      spheres.push(sphere);
      around.push(sphere.clone().translate(now.clone().negate()));
    }
    if (i === 0) {
      start = now;
      size = box.getSize(new Vector3()).length();
    }
  }
  pose(0);
  model.updateMatrixWorld(true);
  return { start, size, box: all, spheres, around };
}

function makeGround({ box, start, size }, level) {
  // cells of half a metre under a body, of half a centimetre under a mechanism of some centimetres
  const scale = 10 ** Math.min(0, Math.floor(Math.log10(size / 0.7)));
  const extent = Math.max(size, box.getSize(new Vector3()).length() / 2);
  const cells = Math.max(2, Math.ceil((extent / scale) * 2));
  const reach = cells * scale;
  const group = new Group();
  let grid = null;
  const colour = () => {
    if (grid) {
      group.remove(grid);
      grid.geometry.dispose();
      grid.material.dispose();
    }
    const line = new Color(css('--grid'));
    grid = new GridHelper(reach * 2, cells * 4, line, line);
    grid.material = new LineBasicMaterial({ color: line, transparent: true, opacity: 0.55 });
    group.add(grid);
  };
  colour();
  const shade = new Mesh(new CircleGeometry(reach, 48), new ShadowMaterial({ opacity: 0.22 }));
  shade.rotation.x = -Math.PI / 2;
  shade.position.y = 0.001 * scale;
  shade.receiveShadow = true;
  group.add(shade);
  const round = (x) => Math.round(x / scale) * scale;
  group.position.set(round(start.x), level - 0.002 * scale, round(start.z));
  return { group, colour };
}

function addLights(scene, { size }) {
  scene.add(new HemisphereLight(0xffffff, 0x8a8f98, 1.5), new AmbientLight(0xffffff, 0.35));
  const key = new DirectionalLight(0xffffff, 2.2);
  const fill = new DirectionalLight(0xffffff, 0.6);
  const direction = new Vector3(-0.7, 1.5, 1.1).multiplyScalar(size * 1.5);
  key.castShadow = true;
  key.shadow.mapSize.set(1536, 1536);
  key.shadow.radius = 3;
  key.shadow.bias = -0.0005;
  key.shadow.normalBias = 0.01;
  Object.assign(key.shadow.camera, {
    left: -size,
    right: size,
    top: size,
    bottom: -size,
    near: 0.01,
    far: size * 6,
  });
  fill.position.set(1, 0.4, -1);
  scene.add(key, key.target, fill);
  return {
    follow(point) {
      key.target.position.copy(point);
      key.position.copy(point).add(direction);
    },
  };
}
