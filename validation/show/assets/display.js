'use strict';
// The display in its place: each distinct part is one geometry, drawn as often as it is placed.
// Tips swing with their solved complex amplitudes; between base and tip a bimorph is drawn as a
// parabola.  Lengths in millimetres, z up.
(() => {
  const T = window.THREE, data = JSON.parse(document.getElementById('td-data').textContent);
  const root = document.querySelector('.td'), stage = root.querySelector('.td-stage');

  const VERTEX = `
    precision highp float;
    in vec3 position;
    uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
    uniform vec2 amplitude, turn;
    uniform float base, reach, enlarge;
    out vec3 world, eye;
    void main() {
      vec3 p = position;
      float s = clamp((p.z - base) / reach, 0.0, 1.0);
      p.x += enlarge * (amplitude.x * turn.x - amplitude.y * turn.y) * s * s;
      vec4 placed = modelMatrix * vec4(p, 1.0);
      vec4 seen = viewMatrix * placed;
      world = placed.xyz; eye = seen.xyz;
      gl_Position = projectionMatrix * seen;
    }`;
  const FRAGMENT = `
    precision highp float;
    in vec3 world, eye;
    uniform vec3 colour;
    uniform float cut;
    out vec4 shown;
    void main() {
      if (world.x > cut) discard;
      vec3 n = normalize(cross(dFdx(eye), dFdy(eye)));
      float light = 0.42 + 0.5 * abs(n.z) + 0.12 * abs(n.y);
      shown = vec4(colour * light, 1.0);
    }`;

  function numbers(text, Kind) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Kind(bytes.buffer);
  }

  const scene = new T.Scene(), drawn = [];
  for (const part of data.parts) {
    const geometry = new T.BufferGeometry();
    geometry.setAttribute('position', new T.BufferAttribute(numbers(part.points, Float32Array), 3));
    geometry.setIndex(new T.BufferAttribute(numbers(part.triangles, Uint32Array), 1));
    part.places.forEach((place, unit) => {
      const material = new T.RawShaderMaterial({
        vertexShader: VERTEX, fragmentShader: FRAGMENT, glslVersion: T.GLSL3, side: T.DoubleSide,
        uniforms: {
          colour: { value: new T.Color(...part.colour) }, cut: { value: 1e9 },
          amplitude: { value: new T.Vector2(0, 0) }, turn: { value: new T.Vector2(1, 0) },
          base: { value: data.base }, reach: { value: data.reach }, enlarge: { value: 0 },
        },
      });
      const mesh = new T.Mesh(geometry, material);
      mesh.position.set(...place); mesh.frustumCulled = false;
      scene.add(mesh); drawn.push({ mesh, part, unit });
    });
  }

  if (!document.createElement('canvas').getContext('webgl2')) {
    root.querySelector('.td-still').hidden = false;
    root.querySelector('.td-panel').hidden = true;
    return;
  }
  const renderer = new T.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  const canvas = renderer.domElement;
  canvas.tabIndex = 0; canvas.setAttribute('role', 'img');
  stage.append(canvas);
  const camera = new T.OrthographicCamera(-1, 1, 1, -1, -1000, 1000);
  camera.up.set(0, 0, 1);
  camera.position.set(data.centre[0] + 60, data.centre[1] - 44, data.centre[2] + 30);
  const controls = new T.OrbitControls(camera, canvas);
  controls.target.set(...data.centre); controls.enableDamping = false;

  const at = root.querySelector('.td-frequency'), cut = root.querySelector('.td-cut');
  const enlarge = root.querySelector('.td-enlarge'), play = root.querySelector('.td-play');
  const words = root.querySelector('.td-words');
  const si = (v) => (v >= 1e-3 ? `${(1e3 * v).toPrecision(3)} mm` : v >= 1e-6
    ? `${(1e6 * v).toPrecision(3)} µm` : `${(1e9 * v).toPrecision(3)} nm`);

  function told() {
    const row = data.motions[+at.value], size = row.map(([re, im]) => Math.hypot(re, im));
    const driven = size[data.driven];
    let other = -1;
    size.forEach((s, i) => { if (i !== data.driven && (other < 0 || s > size[other])) other = i; });
    // the largest tip swings half a pitch at the middle of the slider
    const drawnAs = data.pitch * +enlarge.value / (Math.max(...size) * 1e3 || 1);
    for (const { mesh, part, unit } of drawn) {
      const u = mesh.material.uniforms;
      u.cut.value = +cut.value;
      if (part.moves) { u.amplitude.value.set(1e3 * row[unit][0], 1e3 * row[unit][1]); u.enlarge.value = drawnAs; }
    }
    const share = other < 0 ? '' : `; largest other tip ${data.units[other]}: ${si(size[other])}, `
      + `${(100 * size[other] / driven).toPrecision(3)} %`;
    words.textContent = `${data.frequency[+at.value].toPrecision(4)} Hz: ${data.units[data.driven]} driven with `
      + `${data.voltage} V, its tip ${si(driven)}${share}; drawn ${drawnAs.toPrecision(2)} times enlarged`;
    at.setAttribute('aria-valuetext', `${data.frequency[+at.value].toPrecision(4)} Hz`);
    canvas.setAttribute('aria-label', `The display, ${data.units.length} generators. ${words.textContent}`);
  }

  const list = root.querySelector('.td-parts');
  for (const part of data.parts) {
    const label = document.createElement('label'), box = document.createElement('input');
    box.type = 'checkbox'; box.checked = true;
    const patch = document.createElement('i');
    patch.style.background = `rgb(${part.colour.map((c) => Math.round(255 * c)).join()})`;
    label.append(box, patch, `${part.title} (${part.places.length})`); list.append(label);
    box.addEventListener('change', () => {
      drawn.forEach((d) => { if (d.part === part) d.mesh.visible = box.checked; });
    });
  }

  function fitted() {
    const w = Math.max(stage.clientWidth, 1), h = Math.max(stage.clientHeight, 1);
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.setSize(w, h);
    const half = 0.56 * data.size * Math.max(1, h / w);
    camera.left = -half * w / h; camera.right = half * w / h; camera.top = half; camera.bottom = -half;
    camera.updateProjectionMatrix();
  }
  [at, cut, enlarge].forEach((input) => input.addEventListener('input', told));
  new ResizeObserver(fitted).observe(stage);
  let moving = !window.matchMedia('(prefers-reduced-motion: reduce)').matches, phase = 0, last = 0;
  const labelled = () => { play.textContent = moving ? 'stop' : 'move'; };
  play.addEventListener('click', () => { moving = !moving; labelled(); });
  labelled();
  const step = Math.PI / 24, press = {
    ArrowLeft: () => orbit(-step, 0), ArrowRight: () => orbit(step, 0),
    ArrowUp: () => orbit(0, -step), ArrowDown: () => orbit(0, step), ' ': () => play.click(),
  };
  function orbit(around, down) {
    const { target } = controls, arm = camera.position.clone().sub(target), long = arm.length();
    const azimuth = Math.atan2(arm.y, arm.x) + around;
    const polar = Math.min(Math.max(Math.acos(arm.z / long) + down, 0.01), Math.PI - 0.01);
    arm.set(Math.sin(polar) * Math.cos(azimuth), Math.sin(polar) * Math.sin(azimuth), Math.cos(polar));
    camera.position.copy(target).addScaledVector(arm, long);
  }
  canvas.addEventListener('keydown', (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey || !press[e.key]) return;
    e.preventDefault(); press[e.key]();
  });
  fitted(); told();
  function frame(now) {
    if (moving) phase += 2e-3 * Math.PI * Math.min(now - last, 100);
    last = now;
    for (const { mesh, part } of drawn) {
      if (part.moves) mesh.material.uniforms.turn.value.set(Math.cos(phase), Math.sin(phase));
    }
    controls.update(); renderer.render(scene, camera);
    window.requestAnimationFrame(frame);
  }
  window.requestAnimationFrame(frame);
})();
