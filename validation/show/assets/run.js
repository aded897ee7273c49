'use strict';
// A run of the generator: the body follows the run's coordinates at their true times, the curves
// beneath carry the same instant.  Numbers come from the run; here is only linear interpolation
// between its samples, and the enlargement that is stated.
(async () => {
  const T = window.THREE, root = document.querySelector('.tr');
  const data = await unpacked(JSON.parse(document.getElementById('tr-data').textContent));
  const find = (name) => root.querySelector(`.tr-${name}`);

  const VERTEX = `
    precision highp float;
    in vec3 position;
    uniform mat4 modelViewMatrix, projectionMatrix;
    out vec3 eye;
    void main() {
      vec4 seen = modelViewMatrix * vec4(position, 1.0);
      eye = seen.xyz;
      gl_Position = projectionMatrix * seen;
    }`;
  const FRAGMENT = `
    precision highp float;
    in vec3 eye;
    uniform vec3 colour;
    out vec4 shown;
    void main() {
      vec3 n = normalize(cross(dFdx(eye), dFdy(eye)));
      shown = vec4(colour * (0.62 + 0.38 * abs(dot(n, normalize(vec3(0.35, 0.55, 0.76))))), 1.0);
    }`;
  const FLAT = `
    precision highp float;
    uniform vec3 colour;
    out vec4 shown;
    void main() { shown = vec4(colour, 1.0); }`;

  const { points: rest, lateral, axial, width, samples, coordinates: motion, curves, forces, phase } = data;
  const count = rest.length / 3;
  const last = samples - 1, until = data.until;

  // ---- the body ---------------------------------------------------------------------------

  const place = new Float32Array(3 * count), q = new Float32Array(width);
  let scene = null, renderer = null, camera, controls, attribute, rings = [];
  const calm = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
  const within = root.classList.contains('tr-within');
  let at = 0, playing = !calm && !within, before = 0;
  const scale = { lateral: data.drawn.lateral, lift: data.drawn.lift };

  function mixed(values, stride, column) {
    const k = Math.min(Math.floor(at), last), share = at - k, next = Math.min(k + 1, last);
    return values[k * stride + column] * (1 - share) + values[next * stride + column] * share;
  }

  function moved() {
    for (let c = 0; c < width; c++) q[c] = mixed(motion, width, c);
    for (let p = 0; p < count; p++) {
      let along = 0, up = 0;
      for (let c = 0; c < width; c++) {
        along += lateral[p * width + c] * q[c]; up += axial[p * width + c] * q[c];
      }
      place[3 * p] = 1e3 * (rest[3 * p] + scale.lateral * along);
      place[3 * p + 1] = 1e3 * rest[3 * p + 1];
      // sections turn with the lateral motion, so that they stay square to it
      place[3 * p + 2] = 1e3 * (rest[3 * p + 2] + scale.lift * q[0] + scale.lateral * (up - q[0]));
    }
    if (attribute) attribute.needsUpdate = true;
  }

  function ring(level) {
    const corners = [];
    for (const radius of [1.0, 1.12, 1.24]) {
      for (let k = 0; k < 64; k++) {
        for (const angle of [k, k + 1]) {
          const turn = angle * Math.PI / 32, r = 1e3 * data.rim * radius;
          corners.push(r * Math.cos(turn), r * Math.sin(turn), 0);
        }
      }
    }
    const made = new T.BufferGeometry(), colour = { value: new T.Color(0.5, 0.5, 0.5) };
    made.setAttribute('position', new T.BufferAttribute(new Float32Array(corners), 3));
    const drawn = new T.LineSegments(made, new T.RawShaderMaterial({
      glslVersion: T.GLSL3, vertexShader: VERTEX, fragmentShader: FLAT, uniforms: { colour } }));
    drawn.frustumCulled = false;
    scene.add(drawn);
    return { drawn, level, colour };
  }

  function staged() {
    try {
      renderer = new T.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    } catch (error) {
      find('none').hidden = false;
      return;
    }
    renderer.outputColorSpace = 'srgb-linear'; // colours are given as they are shown
    renderer.setClearColor(0x000000, 0);
    renderer.domElement.tabIndex = 0;
    renderer.domElement.setAttribute('role', 'img');
    renderer.domElement.setAttribute('aria-label', 'the generator as it moves');
    find('stage').prepend(renderer.domElement);
    scene = new T.Scene();
    attribute = new T.BufferAttribute(place, 3);
    for (const region of data.regions) {
      const made = new T.BufferGeometry();
      made.setAttribute('position', attribute);
      made.setIndex(new T.BufferAttribute(region.triangles, 1));
      const mesh = new T.Mesh(made, new T.RawShaderMaterial({
        glslVersion: T.GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, side: T.DoubleSide,
        uniforms: { colour: { value: new T.Color(...region.colour) } } }));
      mesh.frustumCulled = false;
      scene.add(mesh);
    }
    rings = [ring(0), ring(-data.stroke)];
    camera = new T.OrthographicCamera(-1, 1, 1, -1, -1000, 1000);
    camera.up.set(0, 0, 1);
    controls = new T.OrbitControls(camera, renderer.domElement);
    controls.enableDamping = false;
    seen([0.45, -1, 0.3]);
    new ResizeObserver(fitted).observe(find('stage'));
    fitted();
  }

  function seen(from) {
    if (!controls) return;
    const [low, high] = data.heights, middle = 500 * (low + high);
    controls.target.set(0, 0, middle);
    camera.position.set(50 * from[0], 50 * from[1], middle + 50 * from[2]);
    camera.zoom = 1;
    camera.updateProjectionMatrix();
  }

  function fitted() {
    const w = Math.max(find('stage').clientWidth, 1), h = Math.max(find('stage').clientHeight, 1);
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.setSize(w, h);
    const half = 1e3 * 0.58 * (data.heights[1] - data.heights[0]);
    camera.left = -half * w / h; camera.right = half * w / h; camera.top = half; camera.bottom = -half;
    camera.updateProjectionMatrix();
  }

  // ---- words and curves -------------------------------------------------------------------

  const SVG = 'http://www.w3.org/2000/svg';
  function svg(tag, attributes) {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    return made;
  }
  const cells = {};
  function row(key, title) {
    const line = document.createElement('tr'), head = document.createElement('th');
    head.scope = 'row'; head.textContent = title;
    cells[key] = document.createElement('td');
    line.append(head, cells[key]);
    find('values').append(line);
  }
  const lines = [];
  for (const curve of curves) {
    row(curve.key, curve.title);
    let low = Math.min(...curve.values), high = Math.max(...curve.values);
    const box = document.createElement('div'), words = document.createElement('div');
    box.className = 'tr-curve';
    const small = document.createElement('small');
    small.textContent = `${low.toPrecision(3)} to ${high.toPrecision(3)} ${curve.unit}`;
    words.append(`${curve.title}`, document.createElement('br'), small);
    if (high === low) { low -= 1; high += 1; }
    const picture = svg('svg', { viewBox: `0 0 ${last} 100`, preserveAspectRatio: 'none', role: 'img' });
    picture.setAttribute('aria-label', `${curve.title} over time`);
    for (let from = 0, k = 1; k <= samples; k++) {
      if (k < samples && phase[k] === phase[from]) continue;
      picture.append(svg('rect', { x: from, y: 0, width: Math.min(k, last) - from, height: 100,
        fill: `var(--${data.phases[phase[from]].name})` }));
      from = k;
    }
    const path = Array.from(curve.values, (v, k) => `${k} ${(96 - 92 * (v - low) / (high - low)).toFixed(2)}`);
    picture.append(svg('path', { d: `M${path.join('L')}` }));
    const cursor = svg('line', { y1: 0, y2: 100 });
    picture.append(cursor); lines.push(cursor);
    const pick = (event) => {
      if (event.type === 'pointermove' && !event.buttons) return;
      const frame = picture.getBoundingClientRect();
      go(Math.min(Math.max((event.clientX - frame.left) / frame.width, 0), 1) * last);
      run(false);
    };
    picture.addEventListener('pointerdown', pick);
    picture.addEventListener('pointermove', pick);
    box.append(words, picture);
    find('rows').append(box);
  }
  row('upper', 'upper stop'); row('lower', 'lower stop');
  for (const kind of data.phases) {
    const entry = document.createElement('span'), patch = document.createElement('i');
    patch.style.background = `var(--${kind.name})`;
    entry.append(patch, kind.words);
    find('legend').append(entry);
  }

  const time = find('time'), play = find('play'), speed = find('speed');
  const sliders = { lateral: find('lateral'), lift: find('lift') };
  const factor = (v) => Number(v.toPrecision(2)).toLocaleString('en');

  function told() {
    const k = Math.min(Math.round(at), last), kind = data.phases[phase[k]];
    const ms = `${(1e3 * until * at / last).toFixed(3)} ms`;
    find('clock').textContent = ms;
    find('state').textContent = `rod ${kind.words}`;
    find('state').style.borderColor = `var(--${kind.name})`;
    curves.forEach((c) => { cells[c.key].textContent = `${mixed(c.values, 1, 0).toPrecision(3)} ${c.unit}`; });
    ['upper', 'lower'].forEach((name, n) => {
      const force = forces[n][k];
      cells[name].textContent = force > data.touch ? `${force.toPrecision(3)} mN` : 'free';
      if (rings[n]) {
        rings[n].drawn.position.z = 1e3 * scale.lift * rings[n].level;
        rings[n].colour.value.set(...(force > data.touch ? [0.85, 0.33, 0.0] : [0.55, 0.6, 0.65]));
      }
    });
    lines.forEach((line) => { line.setAttribute('x1', at); line.setAttribute('x2', at); });
    time.value = at; time.setAttribute('aria-valuetext', `${ms}, ${kind.words}`);
    root.dataset.sample = String(k);
    for (const key of ['lateral', 'lift']) find(`${key}-by`).textContent = `× ${factor(scale[key])}`;
  }

  function go(where) { at = Math.min(Math.max(where, 0), last); }
  function run(on) { playing = on; play.textContent = on ? 'pause' : 'play'; play.setAttribute('aria-pressed', String(on)); }

  time.max = last;
  time.addEventListener('input', () => { go(+time.value); run(false); });
  play.addEventListener('click', () => { if (!playing && at >= last) go(0); run(!playing); });
  for (const key of ['lateral', 'lift']) {
    sliders[key].addEventListener('input', () => { scale[key] = data.drawn[key] * 10 ** +sliders[key].value; });
  }
  for (const button of find('buttons').children) {
    button.addEventListener('click', () => seen(button.dataset.from.split(' ').map(Number)));
  }
  (within ? root : document).addEventListener('keydown', (event) => {
    if (event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
    const step = { ArrowLeft: -1, ArrowRight: 1, PageUp: -50, PageDown: 50 }[event.key];
    if (step) { go(Math.round(at) + step); run(false); } else if (event.key === 'Home') go(0);
    else if (event.key === 'End') go(last);
    else if (event.key === ' ' && !(event.target instanceof HTMLButtonElement)) play.click();
    else return;
    event.preventDefault();
  });
  // an address that ends in #5.2ms opens there, at rest
  function linked() {
    const named = /^#([\d.]+)ms$/.exec(window.location.hash);
    if (named) { go(1e-3 * +named[1] / until * last); run(false); }
  }
  window.addEventListener('hashchange', linked);

  staged(); run(playing); linked();
  function frame(now) {
    const passed = Math.min(now - before, 100);
    before = now;
    if (playing) {
      at += 1e-6 * passed * +speed.value / until * last; // speed: ms of the run in a second
      if (at >= last) at = calm ? last : at % last;
    }
    moved(); told();
    if (renderer) { controls.update(); renderer.render(scene, camera); }
    root.dataset.ready = '1';
    window.requestAnimationFrame(frame);
  }
  window.requestAnimationFrame(frame);
})();
