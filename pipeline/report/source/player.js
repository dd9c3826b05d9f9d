// The moving body: body.glb in three.js, with its own clock.
import { Raycaster, Vector2, Vector3 } from 'three';
import { makeBody, views } from './body_scene.js';
import { darkScheme, fixed, h, onResize, partTitle, significant } from './dom.js';
import { axisColours, makeEllipsoid } from './inertia_ellipsoid.js';

const speeds = [0.01, 0.1, 0.25, 0.5, 1, 2];

/**
 * The player; `glb` are the bytes of the model, `facts` maps a part's name to {mass, share} in the table's order,
 * `centrePath` = {times, points} is the gravity centre's path in the world (Z up, m), `loads` = {times, forces, origin} the
 * ground forces (see makeForceArrows); each may be null.
 */
export async function makePlayer(glb, facts, centrePath, loads) {
  const canvas = h('canvas', {
    tabindex: 0,
    role: 'img',
    'aria-label':
      'The body in motion, in three dimensions. Arrow keys turn it, plus and minus zoom, space plays.',
  });
  const tip = h('div', { class: 'tip', role: 'status', hidden: true });
  const stage = h('div', { class: 'stage' }, canvas, tip);
  const body = await makeBody(canvas, glb, centrePath, loads);
  const clock = makeClock(body);
  const legend = makeLegend(body, facts, stage);
  pointAtParts(stage, canvas, tip, body, legend, facts);
  steerByKeys(canvas, body, clock);
  if (body.duration > 0) stage.append(clock.bigButton);

  const frame = h(
    'div',
    { class: 'player' },
    h('div', { class: 'player-main' }, stage, controlsOf(body, clock)),
    legend.element,
  );
  onResize(stage, () => body.resize());
  darkScheme.addEventListener('change', () => body.colour());
  return {
    element: frame,
    seek: clock.seek,
    pause: clock.pause,
    duration: body.duration,
    onTime: clock.onTime,
    pick: legend.pick,
    start: () => body.resize(),
  };
}

/** A leap takes only a second, too fast to watch. */
const usualSpeed = ({ duration }) =>
  duration > 0 ? (speeds.findLast((s) => s <= 1 && duration / s > 1.5) ?? speeds[0]) : 1;

/** Play, pause, seek; time runs at `speed` times the wall clock and restarts at the end. */
function makeClock(body) {
  const listeners = [];
  let time = 0;
  let playing = false;
  let speed = usualSpeed(body);
  let loops = true;
  let last = 0;
  const tell = () => listeners.forEach((listen) => listen(time, playing));
  const show = (to) => {
    time = Math.min(Math.max(to, 0), body.duration);
    body.pose(time);
    body.drawNow();
    tell();
  };
  const tick = (now) => {
    if (!playing) return;
    const next = time + (Math.min(now - last, 100) / 1000) * speed;
    last = now;
    if (next > body.duration && !loops) {
      show(body.duration);
      return pause();
    }
    show(next > body.duration ? 0 : next);
    requestAnimationFrame(tick);
  };
  const pause = () => {
    playing = false;
    tell();
  };
  const play = () => {
    if (body.duration === 0) return;
    playing = true;
    if (time >= body.duration) time = 0;
    last = performance.now();
    tell();
    requestAnimationFrame(tick);
  };
  const toggle = () => (playing ? pause() : play());
  const bigButton = h(
    'button',
    { class: 'big-play', 'aria-label': 'Play the motion', onclick: play },
    h('svg', { viewBox: '0 0 48 48', 'aria-hidden': 'true' }, h('path', { d: 'M17 12 L37 24 L17 36 Z' })),
  );
  listeners.push((_, on) => {
    bigButton.hidden = on || time > 0;
  });
  return {
    pause,
    play,
    toggle,
    bigButton,
    seek(to) {
      pause();
      show(to);
    },
    step(by) {
      pause();
      show(time + by);
    },
    setSpeed(to) {
      speed = to;
    },
    setLoop(on) {
      loops = on;
    },
    onTime: (listen) => listeners.push(listen),
  };
}

function controlsOf(body, clock) {
  const icons = { play: 'M8 5 L19 12 L8 19 Z', pause: 'M7 5 H10.5 V19 H7 Z M13.5 5 H17 V19 H13.5 Z' };
  const shape = h('path', { d: icons.play });
  const button = h(
    'button',
    { class: 'round', 'aria-label': 'Play', onclick: clock.toggle },
    h('svg', { viewBox: '0 0 24 24', 'aria-hidden': 'true' }, shape),
  );
  const decimals = body.duration < 2 ? 3 : 2;
  const scrub = h('input', {
    type: 'range',
    min: 0,
    max: body.duration,
    step: 'any',
    value: 0,
    'aria-label': 'Time of the motion in seconds',
    oninput: () => clock.seek(Number(scrub.value)),
  });
  const reading = h('output', { class: 'time' });
  const speed = h(
    'select',
    { 'aria-label': 'Speed', onchange: () => clock.setSpeed(Number(speed.value)) },
    speeds.map((s) => h('option', { value: s, selected: s === usualSpeed(body) }, `${s}×`)),
  );
  const show = (time, playing) => {
    shape.setAttribute('d', playing ? icons.pause : icons.play);
    button.setAttribute('aria-label', playing ? 'Pause' : 'Play');
    scrub.value = time;
    scrub.style.setProperty('--done', `${(100 * time) / (body.duration || 1)}%`);
    reading.textContent = `${fixed(time, decimals)} / ${fixed(body.duration, decimals)} s`;
  };
  clock.onTime(show);
  show(0, false);
  const step = (by, text, name) =>
    h('button', { class: 'small', 'aria-label': name, title: name, onclick: () => clock.step(by) }, text);
  const steps = h('span', { class: 'group' }, step(-1 / 60, '‹', 'A sixtieth of a second back'), step(1 / 60, '›', 'A sixtieth of a second on'));
  const box = (label, checked, change) => {
    const input = h('input', { type: 'checkbox', checked, onchange: () => change(input.checked) });
    return h('label', { class: 'check' }, input, label);
  };
  return h(
    'div',
    { class: 'controls' },
    body.duration > 0
      ? h('div', { class: 'transport' }, button, scrub, reading, steps, speed)
      : h('p', { class: 'quiet' }, 'This run has no motion: the body stands as it was scanned.'),
    h(
      'div',
      { class: 'looks' },
      h(
        'span',
        { class: 'group', role: 'group', 'aria-label': 'View' },
        Object.keys(views).map((name) =>
          h('button', { class: 'small', onclick: () => body.look(name) }, name),
        ),
      ),
      box('Ground', true, (on) => {
        body.ground.group.visible = on;
        body.ask();
      }),
      body.path
        ? box('Gravity centre', true, (on) => {
            body.path.group.visible = on;
            body.ask();
          })
        : null,
      body.arrows
        ? box('Ground forces (1 m: 1000 N)', true, (on) => {
            body.arrows.group.visible = on;
            body.ask();
          })
        : null,
      box('Parts', true, (on) => {
        for (const solid of body.solids) solid.material.visible = on;
        body.ask();
      }),
      box('Frames', false, (on) => {
        for (const frame of body.frames) frame.visible = on;
        body.ask();
      }),
      body.duration > 0 ? box('Follow', body.follows(), (on) => body.setFollow(on)) : null,
      body.duration > 0 ? box('Loop', true, clock.setLoop) : null,
    ),
  );
}

/** The list of parts beside the body; hovering or focusing highlights a part, a click selects it. */
function makeLegend(body, facts, stage) {
  let kept = null;
  let ellipsoid = null;
  const note = h('p', { class: 'ellipsoid-note', hidden: true });
  const rows = new Map();
  const light = (name) => {
    for (const solid of body.solids) {
      const on = name === null || solid.name === name;
      solid.material.transparent = !on;
      solid.material.opacity = on ? 1 : 0.16;
      solid.material.depthWrite = on;
      solid.material.needsUpdate = true;
    }
    for (const [key, row] of rows) row.classList.toggle('lit', key === name);
    body.ask();
  };
  const keep = (name) => {
    kept = kept === name ? null : name;
    for (const [key, row] of rows) row.setAttribute('aria-pressed', key === kept);
    light(kept);
    showInertia(kept);
  };
  /** The selected part's inertia, and its principal moments below the list. */
  const showInertia = (name) => {
    ellipsoid?.removeFromParent();
    const solid = body.solids.find((one) => one.name === name);
    const inertia = facts.get(name)?.inertia;
    ellipsoid = solid ? makeEllipsoid(inertia, solid.userData.patient_from_solid) : null;
    if (ellipsoid) solid.add(ellipsoid);
    note.hidden = !ellipsoid;
    if (ellipsoid)
      note.replaceChildren(
        h('strong', {}, partTitle(name)),
        ': ellipsoid of its mass and principal moments, ',
        ...inertia.moments.map((moment, i) =>
          h('span', { style: { 'border-bottom': `2px solid ${axisColours[i]}` } }, significant(moment * 1e4, 3), i < 2 ? ', ' : ' kg cm²'),
        ),
        ', about its gravity centre.',
      );
    body.ask();
  };
  /** Selects a part chosen elsewhere on the page, and scrolls to the scene. */
  const pick = (name) => {
    if (!rows.has(name)) return;
    if (kept !== name) keep(name);
    stage.scrollIntoView({ block: 'nearest' });
  };
  const order = [...facts.keys()];
  for (const { name, material } of body.solids.toSorted(
    (a, b) => order.indexOf(a.name) - order.indexOf(b.name),
  )) {
    const fact = facts.get(name);
    rows.set(
      name,
      h(
        'button',
        {
          class: 'part',
          'aria-pressed': 'false',
          onmouseenter: () => light(name),
          onmouseleave: () => light(kept),
          onfocus: (event) => {
            if (event.target.matches(':focus-visible')) light(name);
          },
          onblur: () => light(kept),
          onclick: () => keep(name),
        },
        h('span', { class: 'swatch', style: { background: `#${material.color.getHexString()}` } }),
        h('span', { class: 'name' }, partTitle(name)),
        h('span', { class: 'value' }, fact ? `${significant(fact.mass, 3)} kg` : ''),
      ),
    );
  }
  const help = h(
    'p',
    { class: 'help' },
    'Drag to turn, right button to move. Wheel to zoom after a click, or with Ctrl. Keys: arrows, + and −, space, comma and point.',
  );
  return {
    element: h('div', { class: 'legend', role: 'group', 'aria-label': 'Parts' }, [...rows.values()], note, help),
    keep,
    pick,
  };
}

function pointAtParts(stage, canvas, tip, body, legend, facts) {
  const ray = new Raycaster();
  const spot = new Vector2();
  const pick = (event) => {
    const frame = canvas.getBoundingClientRect();
    spot.set(
      ((event.clientX - frame.left) / frame.width) * 2 - 1,
      1 - ((event.clientY - frame.top) / frame.height) * 2,
    );
    ray.setFromCamera(spot, body.camera);
    return ray.intersectObjects(body.solids, false)[0]?.object ?? null;
  };
  let pressed = null;
  canvas.addEventListener('pointerdown', (event) => {
    pressed = [event.clientX, event.clientY];
  });
  canvas.addEventListener('pointerup', (event) => {
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
    const solid = pick(event);
    if (solid) legend.keep(solid.name);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (event.buttons) return;
    const solid = pick(event);
    tip.hidden = !solid;
    if (!solid) return;
    const fact = facts.get(solid.name);
    tip.replaceChildren(
      h('strong', {}, partTitle(solid.name)),
      fact ? ` ${significant(fact.mass, 4)} kg, ${fixed(fact.share, 2)} % of the body` : '',
    );
    const frame = stage.getBoundingClientRect();
    tip.style.left = `${Math.min(event.clientX - frame.left + 14, frame.width - 190)}px`;
    tip.style.top = `${event.clientY - frame.top + 16}px`;
  });
  canvas.addEventListener('pointerleave', () => {
    tip.hidden = true;
  });
}

function steerByKeys(canvas, body, clock) {
  const offset = new Vector3();
  canvas.addEventListener('keydown', (event) => {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    offset.copy(body.camera.position).sub(body.orbit.target);
    if (turn) {
      offset.applyAxisAngle(new Vector3(0, 1, 0), turn[0] * 0.12);
      const side = new Vector3(0, 1, 0).cross(offset).normalize();
      const tilted = offset.clone().applyAxisAngle(side, -turn[1] * 0.12);
      if (Math.abs(tilted.y) < 0.99 * tilted.length()) offset.copy(tilted);
    } else if (event.key === '+' || event.key === '=') offset.multiplyScalar(0.9);
    else if (event.key === '-') offset.multiplyScalar(1 / 0.9);
    else if (event.key === ' ') clock.toggle();
    else if (event.key === ',') clock.step(-1 / 60);
    else if (event.key === '.') clock.step(1 / 60);
    else return;
    event.preventDefault();
    body.camera.position.copy(body.orbit.target).add(offset);
    body.orbit.update();
    body.ask();
  });
}
