/* Moving modes and fields in a page: what is drawn, coloured, cut and read off.
 *
 * Displacements and fields arrive as complex amplitudes; the shader forms Re(û e^{jφ}) at
 * every point, so that a harmonic state's true phase shows.  Numbers that are read (tables, names,
 * units) are written by the program; nothing is computed here but pictures of them.
 */
(function () {
  'use strict';

  const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
  const PHASE_STEP = 15;

  const VERTEX = `
    precision highp float;
    in vec3 position; in vec3 re; in vec3 im; in vec2 amplitude; in vec3 tint; in vec3 apart;
    in vec3 bare;  // 1 in rigid bodies, which have no field but their motion
    uniform mat4 modelViewMatrix; uniform mat4 projectionMatrix;
    uniform vec2 turn; uniform float enlarge; uniform float explode;
    uniform int source; uniform vec3 along;
    out vec3 vRest; out vec3 vView; out vec3 vTint; out float vValue; out float vBare;
    vec3 swing() { return re * turn.x - im * turn.y; }
    vec3 moved() { return position + enlarge * swing() + explode * apart; }
    void main() {
      vec4 view = modelViewMatrix * vec4(moved(), 1.0);
      vRest = position; vView = view.xyz; vTint = tint;
      vBare = source > 2 ? bare.x : 0.0;
      vec3 u = swing();
      vValue = source == 1 ? length(u)
             : source == 2 ? dot(u, along)
             : source == 3 ? amplitude.x * turn.x - amplitude.y * turn.y
             : amplitude.x;
      gl_Position = projectionMatrix * view;
    }`;

  const SURFACE = `
    precision highp float;
    in vec3 vRest; in vec3 vView; in vec3 vTint; in float vValue; in float vBare;
    uniform bool plain; uniform vec2 range; uniform sampler2D palette;
    uniform vec4 cut; uniform float glow;
    out vec4 colour;
    void main() {
      if (dot(vRest, cut.xyz) > cut.w) discard;
      vec3 normal = normalize(cross(dFdx(vView), dFdy(vView)));
      float light = 0.62 + 0.38 * abs(dot(normal, normalize(vec3(0.35, 0.55, 0.76))));
      light = mix(light, 1.0, glow);
      float share = clamp((vValue - range.x) / (range.y - range.x), 0.0, 1.0);
      vec3 base = plain || vBare > 0.5 ? vTint : texture(palette, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb;
      colour = vec4(base * light, 1.0);
    }`;

  const LINES = `
    precision highp float;
    in vec3 vRest; in vec3 vView; in vec3 vTint; in float vValue;
    uniform vec4 ink; uniform vec4 cut;
    out vec4 colour;
    void main() {
      if (dot(vRest, cut.xyz) > cut.w) discard;
      colour = ink;
    }`;

  function element(tag, attributes, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes || {})) {
      if (name === 'class') made.className = value;
      else if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
      else if (value === true) made.setAttribute(name, '');
      else if (value !== false && value != null) made.setAttribute(name, value);
    }
    made.append(...children);
    return made;
  }

  /** A result at the k-th of its lengths: points and shapes are polynomials in the length. */
  function stretched(result, k) {
    const own = result.lengths, at = own.at[k];
    const weights = own.solved.map((node, j) => own.solved.reduce(
      (w, other, i) => (i === j ? w : w * (at - other) / (node - other)), 1));
    const mix = (start, parts) => {
      const out = Float32Array.from(start);
      parts.forEach((part, j) => { for (let i = 0; i < out.length; i++) out[i] += weights[j] * part[i]; });
      return out;
    };
    const points = mix(new Float32Array(own.shapes[0].length), own.shapes);
    const fields = result.fields.filter((f) => f.along || f.source === 1);
    const states = own.modes.map((mode) => {
      const moved = mix(mode.middle, mode.apart), tops = {};
      for (const field of fields) {
        let top = 0;
        for (let i = 0; i < moved.length; i += 3) {
          const u = [moved[i], moved[i + 1], moved[i + 2]];
          top = Math.max(top, field.source === 1 ? Math.hypot(...u) : Math.abs(u.reduce((s, v, c) => s + v * field.along[c], 0)));
        }
        tops[field.key] = top;
      }
      const here = result.states.find((s) => s.name === mode.name);
      return { ...here, text: mode.texts[k], detail: here.detail.split(' · ')[0], tops, // its k is the scene's length's
        arrays: { displacement: [moved] },
        title: `${here.title}, ${millimetres(at)} long`,
        drawn: mode.drawn.reduce((sum, v, j) => sum + weights[j] * v, 0) };
    });
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    points.forEach((v, i) => { low[i % 3] = Math.min(low[i % 3], v); high[i % 3] = Math.max(high[i % 3], v); });
    const box = { low, high, height: high[2] - low[2], centre: low.map((v, c) => 0.5 * (v + high[c])), width: own.box.width };
    return { ...result, ...own, points, fields, states, box };
  }

  const nearest = (values, wanted) => values.reduce(
    (best, v, k) => (Math.abs(v - wanted) < Math.abs(values[best] - wanted) ? k : best), 0);
  const millimetres = (metres) => +(1e3 * metres).toFixed(3) + ' mm';

  function paletteTexture(stops) {
    const T = window.THREE, data = new Uint8Array(4 * 256);
    for (let k = 0; k < 256; k++) {
      const place = k / 255 * (stops.length - 1), low = Math.min(Math.floor(place), stops.length - 2);
      for (let c = 0; c < 3; c++) {
        const a = stops[low][c], b = stops[low + 1][c];
        data[4 * k + c] = Math.round(a + (b - a) * (place - low));
      }
      data[4 * k + 3] = 255;
    }
    const texture = new T.DataTexture(data, 256, 1, T.RGBAFormat);
    texture.needsUpdate = true;
    return texture;
  }

  /** One result in one half of the picture: its scene, and the state that it shows. */
  class Pane {
    constructor(view, result) {
      const T = window.THREE;
      this.view = view; this.result = result; this.scene = new T.Scene();
      const count = result.points.length / 3;
      const tint = new Float32Array(3 * count), apart = new Float32Array(3 * count);
      const bare = new Float32Array(3 * count);
      for (let k = 0; k < count; k++) {
        const region = result.regions[result.regionOfPoint[k]];
        const side = region.sided && result.points[3 * k] < 0 ? -1 : 1;
        for (let c = 0; c < 3; c++) {
          tint[3 * k + c] = region.colour[c]; apart[3 * k + c] = side * region.apart[c];
          bare[3 * k + c] = region.rigid ? 1 : 0;
        }
      }
      this.constant = { position: result.points, tint, apart, bare };
      this.uniforms = {
        turn: { value: new T.Vector2(1, 0) }, enlarge: { value: 0 }, explode: { value: 0 },
        source: { value: 0 }, along: { value: new T.Vector3() }, plain: { value: true },
        range: { value: new T.Vector2(0, 1) }, palette: { value: view.palettes.magnitude },
        cut: { value: [1, 0, 0, 1e9] }, glow: { value: 0 },
      };
      const material = (fragment, extra, options) => new T.RawShaderMaterial({
        glslVersion: T.GLSL3, vertexShader: VERTEX, fragmentShader: fragment,
        uniforms: Object.assign({}, this.uniforms, extra), side: T.DoubleSide, ...options,
      });
      const offset = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
      this.surface = new T.Mesh(this.geometry(result.triangles), material(SURFACE, {}, offset));
      this.ink = { value: [0, 0, 0, 0.35] };
      this.edges = new T.LineSegments(
        this.geometry(result.edges), material(LINES, { ink: this.ink }, { transparent: true }));
      this.restInk = { value: [0.5, 0.5, 0.5, 0.8] };
      this.rest = new T.LineSegments(this.geometry(result.outline), material(
        LINES, { ink: this.restInk, enlarge: { value: 0 } }, { transparent: true }));
      this.cap = new T.Mesh(new T.BufferGeometry(), material(SURFACE, {}, offset));
      this.cap.visible = false;
      this.lines = null;
      for (const part of [this.surface, this.edges, this.rest, this.cap]) {
        part.frustumCulled = false; this.scene.add(part);
      }
      if (result.lines) this.addLines(material);
    }

    /** Let go of what the graphics processor holds. */
    clear() {
      this.scene.traverse((part) => { if (part.geometry) { part.geometry.dispose(); part.material.dispose(); } });
      this.scene.clear();
    }

    geometry(index) {
      const T = window.THREE, made = new T.BufferGeometry();
      made.setIndex(new T.BufferAttribute(index, 1));
      for (const [name, values] of Object.entries(this.constant)) {
        made.setAttribute(name, new T.BufferAttribute(values, 3));
      }
      return made;
    }

    /** Lines that lie in the section and do not move: flux lines. */
    addLines(material) {
      const T = window.THREE, made = new T.BufferGeometry(), points = this.result.lines;
      made.setAttribute('position', new T.BufferAttribute(points, 3));
      for (const [name, size] of [['re', 3], ['im', 3], ['amplitude', 2], ['tint', 3], ['apart', 3], ['bare', 3]]) {
        made.setAttribute(name, new T.BufferAttribute(new Float32Array(points.length / 3 * size), size));
      }
      this.lineInk = { value: [0, 0, 0, 0.9] };
      const never = { value: [1, 0, 0, 1e9] };
      this.lines = new T.LineSegments(made, material(
        LINES, { ink: this.lineInk, cut: never, enlarge: { value: 0 } }, { transparent: true }));
      this.lines.frustumCulled = false;
      this.scene.add(this.lines);
    }

    show(state, field) {
      const T = window.THREE;
      this.state = state; this.field = field;
      const count = this.result.points.length / 3, zero = new Float32Array(3 * count);
      const [re, im] = state.arrays.displacement || [null, null];
      const amplitude = new Float32Array(2 * count);
      const scalar = field && state.arrays[field.key];
      if (field && field.source >= 3 && scalar) {
        for (let k = 0; k < count; k++) {
          amplitude[2 * k] = scalar[0][k]; amplitude[2 * k + 1] = scalar[1] ? scalar[1][k] : 0;
        }
      }
      this.moving = { re: re || zero, im: im || zero, amplitude };
      for (const part of [this.surface, this.edges, this.rest]) {
        part.geometry.setAttribute('re', new T.BufferAttribute(this.moving.re, 3));
        part.geometry.setAttribute('im', new T.BufferAttribute(this.moving.im, 3));
        part.geometry.setAttribute('amplitude', new T.BufferAttribute(amplitude, 2));
      }
      const u = this.uniforms;
      u.plain.value = !field;
      if (field) {
        u.source.value = field.source;
        u.along.value.set(...(field.along || [0, 0, 0]));
        const top = state.tops[field.key] || 1e-30;
        u.range.value.set(field.signed ? -top : 0, top);
        u.palette.value = field.signed ? this.view.palettes.signed : this.view.palettes.magnitude;
      }
      this.slice();
    }

    /** The face of the cut: every cell as six tetrahedra, each crossed by the plane. */
    slice() {
      const T = window.THREE, { axis, at } = this.view.options.cut, cells = this.result.cells;
      this.cap.visible = axis !== 'none' && !!cells;
      if (!this.cap.visible) return;
      const dimension = 'xyz'.indexOf(axis), level = at * 1e-3, points = this.result.points;
      const size = this.result.cellSize;
      const tets = size === 8
        ? [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
        : [[0, 1, 2, 3]];
      const corners = [];
      const height = (p) => points[3 * p + dimension] - level;
      for (let c = 0; c < cells.length; c += size) {
        let low = Infinity, high = -Infinity;
        for (let k = 0; k < Math.min(size, 8); k++) {
          const h = height(cells[c + k]); low = Math.min(low, h); high = Math.max(high, h);
        }
        if (low > 0 || high <= 0) continue;
        for (const tet of tets) {
          const above = [], below = [];
          for (const k of tet) (height(cells[c + k]) > 0 ? above : below).push(cells[c + k]);
          const cross = (a, b) => [a, b, -height(a) / (height(b) - height(a))];
          if (above.length === 1 || below.length === 1) {
            const [one, others] = above.length === 1 ? [above[0], below] : [below[0], above];
            for (const other of others) corners.push(cross(one, other));
          } else if (above.length === 2 && below.length === 2) {
            const [a, b] = above, [p, q] = below;
            corners.push(cross(a, p), cross(a, q), cross(b, q), cross(a, p), cross(b, q), cross(b, p));
          }
        }
      }
      const made = new T.BufferGeometry();
      for (const [name, values] of Object.entries({ ...this.constant, ...this.moving })) {
        const width = name === 'amplitude' ? 2 : 3, out = new Float32Array(width * corners.length);
        corners.forEach(([a, b, share], k) => {
          for (let c = 0; c < width; c++) {
            out[width * k + c] = values[width * a + c] * (1 - share) + values[width * b + c] * share;
          }
        });
        made.setAttribute(name, new T.BufferAttribute(out, width));
      }
      // rounding must not throw away the face that lies in the plane
      const face = made.getAttribute('position').array;
      for (let k = dimension; k < face.length; k += 3) face[k] = level;
      this.cap.geometry.dispose(); this.cap.geometry = made;
    }

    enlargement() { return this.state.drawn * this.view.options.amplitude; }

    update(phase) {
      const { options, camera, controls } = this.view, u = this.uniforms;
      // what is taken away is the side towards the eye
      const normal = AXES[options.cut.axis], level = options.cut.at * 1e-3;
      const eye = camera.position.toArray().map((v, k) => v - (controls ? controls.target.getComponent(k) : 0));
      const side = normal && normal[0] * eye[0] + normal[1] * eye[1] + normal[2] * eye[2] < 0 ? -1 : 1;
      u.cut.value = normal ? [...normal.map((v) => side * v), side * level + 1e-9] : [1, 0, 0, 1e9];
      const still = this.state.kind === 'static' ? 0 : phase;
      u.turn.value.set(Math.cos(still), Math.sin(still));
      u.enlarge.value = this.enlargement();
      u.explode.value = options.explode * this.result.box.height;
      u.glow.value = this.field ? 0.35 : 0;
      this.edges.visible = options.mesh;
      this.rest.visible = options.rest;
      const dark = this.view.dark;
      this.ink.value = dark ? [1, 1, 1, 0.28] : [0.05, 0.08, 0.12, 0.32];
      this.restInk.value = dark ? [0.75, 0.8, 0.85, 0.8] : [0.35, 0.4, 0.45, 0.8];
      if (this.lines) this.lineInk.value = dark ? [1, 1, 1, 0.85] : [0, 0, 0, 0.85];
    }

    /** Position of a point now, by the same expression as in the shader. */
    place(k, out) {
      const { turn, enlarge, explode } = this.uniforms, { re, im } = this.moving;
      for (let c = 0; c < 3; c++) {
        const i = 3 * k + c;
        out[c] = this.constant.position[i] + explode.value * this.constant.apart[i]
          + enlarge.value * (re[i] * turn.value.x - im[i] * turn.value.y);
      }
      return out;
    }

    /** The nearest point of the surface on a ray: triangle, weights of its corners. */
    hit(origin, direction) {
      const index = this.result.triangles, cut = this.uniforms.cut.value;
      const count = this.result.points.length / 3, placed = new Float32Array(3 * count), p = [0, 0, 0];
      for (let k = 0; k < count; k++) placed.set(this.place(k, p), 3 * k);
      let best = null;
      const get = (k) => placed.subarray(3 * k, 3 * k + 3);
      const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
      const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
      const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
      for (let t = 0; t < index.length; t += 3) {
        const [a, b, c] = [index[t], index[t + 1], index[t + 2]];
        const e1 = minus(get(b), get(a)), e2 = minus(get(c), get(a));
        const h = cross(direction, e2), det = dot(e1, h);
        if (Math.abs(det) < 1e-20) continue;
        const s = minus(origin, get(a)), u = dot(s, h) / det;
        if (u < 0 || u > 1) continue;
        const q = cross(s, e1), v = dot(direction, q) / det;
        if (v < 0 || u + v > 1) continue;
        const far = dot(e2, q) / det, weights = [1 - u - v, u, v], corners = [a, b, c];
        let rest = 0;
        corners.forEach((k, n) => {
          for (let i = 0; i < 3; i++) rest += weights[n] * this.constant.position[3 * k + i] * cut[i];
        });
        if (rest > cut[3]) continue;
        if (!best || far < best.far) best = { far, corners, weights };
      }
      return best;
    }

    /** What is at a hit: place at rest, displacement now, value now and its amplitude. */
    reading(hit) {
      const { re, im, amplitude } = this.moving, { turn } = this.uniforms;
      const mix = (values, width, c) => hit.corners.reduce(
        (sum, k, n) => sum + hit.weights[n] * values[width * k + c], 0);
      const now = [0, 1, 2].map((c) => mix(re, 3, c) * turn.value.x - mix(im, 3, c) * turn.value.y);
      const rest = [0, 1, 2].map((c) => mix(this.constant.position, 3, c));
      const region = this.result.regions[this.result.regionOfPoint[hit.corners[0]]];
      const field = this.field;
      let value = Math.hypot(...now);
      if (field && field.source === 2) value = now.reduce((s, v, c) => s + v * field.along[c], 0);
      if (field && field.source === 3) {
        value = mix(amplitude, 2, 0) * turn.value.x - mix(amplitude, 2, 1) * turn.value.y;
      }
      if (field && field.source === 4) value = mix(amplitude, 2, 0);
      return { rest, now, region, value };
    }
  }

  class View {
    constructor(root, payload) {
      this.root = root; this.payload = payload;
      const calm = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
      this.options = {
        playing: !calm, speed: 0.5, amplitude: 1, phase: 0, mesh: true, rest: false, explode: 0,
        cut: { axis: 'none', at: 0 }, field: '', circuit: 'short',
      };
      this.scheme = window.matchMedia('(prefers-color-scheme: dark)');
      const light = root.classList.contains('tv-light');
      this.isDark = () => !light && this.scheme.matches;
      this.dark = this.isDark();
      this.panes = []; this.last = null;
      this.length = -1; // as in the scene; else which of the lengths
    }

    async start() {
      this.results = (await unpacked(this.payload)).results;
      const T = window.THREE;
      this.renderer = new T.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
      this.renderer.setClearColor(0x000000, 0);
      this.renderer.outputColorSpace = 'srgb-linear'; // colours are given as they are shown
      this.renderer.autoClear = false;
      this.palettes = {
        magnitude: paletteTexture(this.payload.palettes.magnitude),
        signed: paletteTexture(this.payload.palettes.signed),
      };
      this.camera = new T.OrthographicCamera(-1, 1, 1, -1, -10, 10);
      this.build();
      this.scheme.addEventListener('change', () => { this.dark = this.isDark(); this.draw(); });
      new ResizeObserver(() => this.resize()).observe(this.stage);
      this.choose(0, -1);
      this.resize(); this.look('home');
      this.renderer.setAnimationLoop((now) => this.tick(now));
    }

    // ---- what is shown -------------------------------------------------------------------

    choose(left, right) {
      this.chosen = [left, right];
      const wanted = right < 0 || right === left ? [left] : [left, right];
      for (const pane of this.panes) pane.clear();
      this.panes = wanted.map((k) => new Pane(this, this.at(k)));
      this.listStates(); this.select(this.stateName || this.results[left].states[0].name);
    }

    /** A result at the length of the slider, where it has others. */
    at(k) {
      const result = this.results[k];
      return this.length < 0 || !result.lengths ? result : stretched(result, this.length);
    }

    /** Show the k-th length; -1 is the scene's own, with all its states and colours. */
    stretch(k) {
      const { coloured } = this.chosen, own = this.results.find((r) => r.lengths).lengths;
      this.length = k;
      this.inputs.lengthText.textContent = k < 0 ? 'as in the scene' : millimetres(own.at[k]);
      if (k >= 0) this.inputs.length.value = k;
      this.inputs.ownLength.setAttribute('aria-pressed', String(k < 0));
      this.choose(...this.chosen); this.chosen.coloured = coloured;
    }

    /** States of the first result; a second one shows its own of that kind and place. */
    select(name) {
      const states = this.panes[0].result.states;
      this.state = states.find((s) => s.name === name) || states[0];
      this.stateName = this.state.name;
      if (!this.state.moves && !this.chosen.coloured) {
        this.options.field = this.fieldsNow()[0].key; this.options.mesh = false; this.inputs.mesh.checked = false;
        this.chosen.coloured = true;
      }
      if (this.state.circuit !== 'driven') this.options.circuit = this.state.circuit;
      if (!this.fieldsNow().some((f) => f.key === this.options.field)) this.options.field = '';
      this.listFields();
      this.refresh();
    }

    partner(result) {
      if (result === this.panes[0].result) return this.state;
      return pairing(this.state, this.panes[0].result.states, result.states);
    }

    fieldsNow() { return this.panes[0].result.fields; }

    refresh() {
      for (const pane of this.panes) {
        const state = this.partner(pane.result);
        const field = pane.result.fields.find((f) => f.key === this.options.field) || null;
        pane.missing = !state;
        pane.show(state || pane.result.states[0], field);
      }
      this.words(); this.draw();
    }

    // ---- drawing -------------------------------------------------------------------------

    tick(now) {
      const seconds = this.last === null ? 0 : Math.min((now - this.last) / 1000, 0.1);
      this.last = now;
      if (!this.options.playing || !this.visible()) return;
      this.options.phase = (this.options.phase + 2 * Math.PI * this.options.speed * seconds) % (2 * Math.PI);
      this.draw();
    }

    visible() {
      const box = this.stage.getBoundingClientRect();
      return box.bottom > 0 && box.top < window.innerHeight;
    }

    draw() {
      if (!this.panes.length || !this.width) return;
      const share = this.width / this.panes.length;
      this.renderer.setScissorTest(false); this.renderer.clear();
      this.renderer.setScissorTest(true);
      this.panes.forEach((pane, k) => {
        pane.update(this.options.phase);
        this.renderer.setViewport(k * share, 0, share, this.height);
        this.renderer.setScissor(k * share, 0, share, this.height);
        this.renderer.render(pane.scene, this.camera);
      });
      const degrees = Math.round(this.options.phase * 180 / Math.PI) % 360;
      this.inputs.phase.value = degrees;
      this.inputs.phaseText.textContent = degrees + '°';
      this.overlay();
    }

    resize() {
      const box = this.stage.getBoundingClientRect();
      if (!box.width || !box.height) return;
      this.width = box.width; this.height = box.height;
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      this.renderer.setSize(this.width, this.height);
      this.frame(); this.draw();
    }

    /** The box to fit: where the length slides, the longest device's, so that one scale serves all. */
    tallest() {
      const result = this.results[this.chosen[0]], own = result.lengths;
      if (!own) return result.box;
      const longest = stretched(result, own.at.length - 1).box;
      return longest.height > result.box.height ? longest : result.box;
    }

    /** Fit the orthographic picture: height and width at zoom 1. */
    frame() {
      const aspect = this.width / this.panes.length / this.height;
      const box = this.tallest(), lies = this.lies;
      const long = 1.28 * box.height, wide = Math.max(box.width * 1.6, 0.42 * box.height);
      let tall = lies ? wide : long, across = lies ? long : wide;
      if (across / tall > aspect) tall = across / aspect; else across = tall * aspect;
      Object.assign(this.camera, { left: -across / 2, right: across / 2, top: tall / 2, bottom: -tall / 2 });
      this.camera.near = -10 * box.height; this.camera.far = 10 * box.height;
      this.camera.updateProjectionMatrix();
    }

    look(from) {
      const T = window.THREE, box = this.tallest();
      const aspect = this.width / this.panes.length / this.height;
      // a long thing lies down where the picture is wide
      this.lies = from !== 'upright' && box.height > 2.5 * box.width && aspect > 1.3;
      const opened = !!this.panes[0].result.lines; // into the quarter that is left out
      const up = this.lies ? [opened ? -1 : 1, 0, 0] : [0, 0, 1];
      const upright = [opened ? -0.75 : 0.75, -1.0, 0.45];
      const directions = {
        home: this.lies ? (opened ? [-0.8, -1, 0.25] : [0.5, 1, 0.3]) : upright, upright,
        x: [1, 0, 0], y: [0, -1, 0], z: [0, 0, 1],
      };
      const d = new T.Vector3(...directions[from]).normalize();
      if (from === 'z') up.splice(0, 3, 1, 0, 0);
      if (from === 'x' && this.lies) up.splice(0, 3, 0, -1, 0);
      if (this.controls) this.controls.dispose();
      const target = new T.Vector3(...box.centre);
      this.camera.up.set(...up); this.camera.zoom = 1;
      this.camera.position.copy(target).addScaledVector(d, 2 * box.height);
      this.camera.lookAt(target);
      this.controls = new T.OrbitControls(this.camera, this.renderer.domElement);
      this.controls.target.copy(target); this.controls.enableDamping = false;
      this.controls.addEventListener('change', () => this.draw());
      this.controls.update(); this.frame(); this.draw();
    }

    // ---- words over the picture ----------------------------------------------------------

    overlay() {
      // a length that is round and fills about a sixth of the picture
      const perPixel = (this.camera.right - this.camera.left) / this.camera.zoom / (this.width / this.panes.length);
      const wanted = 110 * perPixel, power = 10 ** Math.floor(Math.log10(wanted));
      const length = [5, 2, 1].map((n) => n * power).find((v) => v <= wanted) || power;
      this.ruler.style.width = length / perPixel + 'px';
      const mm = length * 1e3;
      this.rulerText.textContent = mm >= 0.1 ? +mm.toPrecision(2) + ' mm' : +(mm * 1e3).toPrecision(2) + ' µm';
      const e = this.camera.matrixWorldInverse.elements;
      for (const [k, name] of ['x', 'y', 'z'].entries()) {
        const x = 22 * e[4 * k], y = -22 * e[4 * k + 1];
        this.triad[name].line.setAttribute('x2', x); this.triad[name].line.setAttribute('y2', y);
        this.triad[name].text.setAttribute('x', 1.35 * x); this.triad[name].text.setAttribute('y', 1.35 * y);
      }
    }

    words() {
      const state = this.state, field = this.fieldsNow().find((f) => f.key === this.options.field);
      this.captions.replaceChildren(...this.panes.map((pane) => {
        const own = pane.missing ? null : pane.state;
        const lines = [element('b', {}, pane.result.title)];
        if (own) {
          lines.push(' · ' + own.title, element('br'), own.text);
          if (this.options.field && !pane.field) {
            lines.push(element('br'), element('span', { class: 'tv-dim' }, 'this model has no such field'));
          } else if (own.moves) {
            lines.push(element('br'), element('span', { class: 'tv-dim' }, this.enlarged(pane)));
          }
        } else {
          lines.push(element('br'), `the model ${pane.result.model} has no such state`);
        }
        return element('div', { class: 'tv-caption' }, ...lines);
      }));
      this.bar.hidden = !field;
      if (field) {
        const top = readable(this.panes[0].state.tops[field.key] || 0, field);
        const bottom = field.signed ? '−' + top.value : '0';
        this.barTitle.textContent = `${field.title}${top.unit ? ' (' + top.unit + ')' : ''}`;
        this.barLow.textContent = bottom; this.barHigh.textContent = top.value;
        this.barMiddle.textContent = field.signed ? '0' : '';
        const stops = this.payload.palettes[field.signed ? 'signed' : 'magnitude'];
        this.barStrip.style.background = 'linear-gradient(to right,'
          + stops.map((c) => `rgb(${c.join(',')})`).join(',') + ')';
        this.barNote.textContent = this.panes.length > 1 && this.panes[1].field
          ? 'each side by its own largest value' : state.note;
      }
      const label = `${this.panes.map((p) => p.result.title).join(' and ')}: ${state.title}, ${state.text}`
        + (field ? `, coloured by ${field.title}` : ', coloured by part')
        + (this.options.cut.axis === 'none' ? '' : `, cut across ${this.options.cut.axis}`);
      this.renderer.domElement.setAttribute('aria-label', label);
      this.inputs.play.textContent = this.options.playing ? 'Pause' : 'Play';
      this.inputs.play.setAttribute('aria-pressed', String(this.options.playing));
      for (const [value, button] of Object.entries(this.inputs.circuit)) {
        button.setAttribute('aria-pressed', String(this.options.circuit === value));
      }
      for (const [name, row] of Object.entries(this.rows)) {
        row.setAttribute('aria-selected', String(name === state.name));
      }
      this.legend.hidden = !!field;
      this.legend.replaceChildren(...this.panes[0].result.regions.map((r) => element('span', {},
        element('i', { style: `background:rgb(${r.colour.map((c) => Math.round(255 * c)).join(',')})` }), r.title)));
    }

    enlarged(pane) {
      const times = pane.enlargement();
      if (!times) return 'displacements not drawn';
      return 'displacements × ' + (times >= 100 ? Number(times.toPrecision(3)).toLocaleString('en') : times.toPrecision(3));
    }

    // ---- controls ------------------------------------------------------------------------

    build() {
      const root = this.root, inputs = this.inputs = {};
      const canvas = this.renderer.domElement;
      canvas.setAttribute('role', 'img'); canvas.tabIndex = 0;
      this.stage = element('div', { class: 'tv-stage' });
      this.captions = element('div', { class: 'tv-captions' });
      this.barTitle = element('div', { class: 'tv-bar-title' });
      this.barStrip = element('div', { class: 'tv-strip' });
      this.barLow = element('span'); this.barMiddle = element('span'); this.barHigh = element('span');
      this.barNote = element('div', { class: 'tv-dim' });
      this.bar = element('div', { class: 'tv-bar' }, this.barTitle, this.barStrip,
        element('div', { class: 'tv-ends' }, this.barLow, this.barMiddle, this.barHigh), this.barNote);
      this.legend = element('div', { class: 'tv-legend' });
      this.ruler = element('div', { class: 'tv-ruler' }); this.rulerText = element('span');
      this.tip = element('div', { class: 'tv-tip', role: 'status', 'aria-live': 'polite', hidden: true });
      this.stage.append(canvas, this.captions, element('div', { class: 'tv-foot' }, this.bar, this.legend),
        element('div', { class: 'tv-scale' }, this.makeTriad(), element('div', {}, this.ruler, this.rulerText)), this.tip);
      this.panel = element('div', { class: 'tv-panel' });
      root.replaceChildren(this.stage, this.panel);

      const slider = (key, text, low, high, step, value, format, change) => {
        const out = element('output', {}, format(value));
        const input = element('input', { type: 'range', min: low, max: high, step, value, 'aria-label': text,
          oninput: () => { out.textContent = format(+input.value); change(+input.value); } });
        inputs[key] = input; inputs[key + 'Text'] = out;
        return element('label', { class: 'tv-slider' }, element('span', {}, text), input, out);
      };
      const tick = (key, text, on, change) => {
        const input = element('input', { type: 'checkbox', checked: on, onchange: () => change(input.checked) });
        inputs[key] = input;
        return element('label', { class: 'tv-tick' }, input, text);
      };
      const pick = (key, text, entries, change) => {
        const input = element('select', { 'aria-label': text, onchange: () => change(input.value) },
          ...entries.map(([value, label]) => element('option', { value }, label)));
        inputs[key] = input;
        return element('label', { class: 'tv-pick' }, element('span', {}, text), input);
      };
      const group = (title, ...children) => element('section', {}, element('h3', {}, title), ...children);

      const models = this.results.map((r, k) => [k, r.title]);
      const several = models.length > 1 ? [
        pick('model', 'Model', models, (v) => this.choose(+v, this.chosen[1] === +v ? -1 : this.chosen[1])),
        pick('other', 'Beside it', [[-1, 'nothing'], ...models], (v) => { this.choose(this.chosen[0], +v); this.look('home'); }),
      ] : [];
      inputs.circuit = {};
      this.circuits = element('div', { class: 'tv-buttons', role: 'group', 'aria-label': 'electrodes' },
        ...[['short', 'Short circuit'], ['open', 'Open circuit']].map(([value, text]) => {
          const button = element('button', { type: 'button', onclick: () => this.circuit(value) }, text);
          inputs.circuit[value] = button;
          return button;
        }));
      this.stateList = element('div', { class: 'tv-states', role: 'listbox', 'aria-label': 'states', tabindex: 0 });
      inputs.play = element('button', { type: 'button', class: 'tv-play', onclick: () => this.play() }, 'Pause');
      const home = ['home', 'x', 'y', 'z', 'upright'].map((from) => element('button', {
        type: 'button', onclick: () => this.look(from),
        title: { home: 'the first view', upright: 'z up' }[from] || `along ${from}`,
      }, { home: 'Home', upright: 'Upright' }[from] || from));
      const own = (this.results.find((r) => r.lengths) || {}).lengths;
      const lengths = !own ? [] : [group('Length',
        slider('length', 'Length', 0, own.at.length - 1, 1, nearest(own.at, own.here), () => 'as in the scene', (v) => this.stretch(v)),
        element('div', { class: 'tv-buttons' }, inputs.ownLength = element('button', { type: 'button', 'aria-pressed': 'true',
          onclick: () => this.stretch(-1) }, 'As in the scene')),
        element('p', { class: 'tv-help' }, own.note))];
      const isMoving = this.results.some((r) => r.states.some((s) => s.moves));
      const { conditions } = this.payload;
      this.panel.append(
        ...(conditions ? [element('p', { class: 'tv-help' }, conditions)] : []),
        group('State', ...several, ...(isMoving ? [this.circuits] : []), this.stateList),
        ...lengths,
        group('Colour', pick('field', 'Colour by', [['', 'part']], (v) => { this.options.field = v; this.refresh(); })),
        ...(isMoving ? [group('Motion', inputs.play,
          slider('phase', 'Phase', 0, 359, 1, 0, (v) => v + '°', (v) => { this.pause(); this.options.phase = v * Math.PI / 180; this.draw(); }),
          slider('speed', 'Speed', 0.05, 2, 0.05, 0.5, (v) => v.toFixed(2) + '/s', (v) => { this.options.speed = v; }),
          slider('amplitude', 'Amplitude', 0, 3, 0.05, 1, (v) => v.toFixed(2), (v) => { this.options.amplitude = v; this.words(); this.draw(); }))]
          : [element('div', { hidden: true }, slider('phase', 'Phase', 0, 359, 1, 0, (v) => v + '°', () => {}), inputs.play)]),
        group('Shape',
          element('div', { class: 'tv-ticks' },
            tick('mesh', 'mesh lines', true, (v) => { this.options.mesh = v; this.draw(); }),
            tick('rest', 'shape at rest', false, (v) => { this.options.rest = v; this.draw(); })),
          slider('explode', 'Apart', 0, 1, 0.02, 0, (v) => Math.round(100 * v) + ' %', (v) => { this.options.explode = 0.2 * v; this.draw(); }),
          pick('axis', 'Cut across', [['none', 'nothing'], ['x', 'x'], ['y', 'y'], ['z', 'z']], (v) => this.cut(v)),
          slider('at', 'at', -1, 1, 0.01, 0, (v) => v.toFixed(2) + ' mm', (v) => this.cut(this.options.cut.axis, v))),
        group('Look from', element('div', { class: 'tv-buttons' }, ...home)),
        element('p', { class: 'tv-help' }, 'Drag turns, wheel or two fingers zoom, right button shifts. '
          + 'Point at the device, or tap it, for the value there. Keys: space plays, ← → turn the phase, [ ] change the state, '
          + 'o the circuit, c the colour, m mesh lines, r shape at rest, h home.'));
      this.cutRow = inputs.at.closest('label'); this.cutRow.hidden = true;
      this.keys(); this.pointer();
    }

    makeTriad() {
      const ns = 'http://www.w3.org/2000/svg';
      const svg = document.createElementNS(ns, 'svg');
      svg.setAttribute('viewBox', '-34 -34 68 68'); svg.setAttribute('class', 'tv-triad'); svg.setAttribute('aria-hidden', 'true');
      this.triad = {};
      for (const name of ['x', 'y', 'z']) {
        const line = document.createElementNS(ns, 'line'), text = document.createElementNS(ns, 'text');
        line.setAttribute('x1', 0); line.setAttribute('y1', 0); text.textContent = name;
        svg.append(line, text); this.triad[name] = { line, text };
      }
      return svg;
    }

    listStates() {
      this.rows = {};
      const states = this.panes[0].result.states.filter(
        (s) => s.circuit === 'driven' || s.circuit === this.options.circuit);
      this.stateList.replaceChildren(...states.map((s) => {
        const row = element('div', { class: 'tv-state', role: 'option', 'aria-selected': 'false', onclick: () => this.select(s.name) },
          element('span', {}, s.short), element('span', {}, s.text), element('span', { class: 'tv-dim' }, s.detail));
        this.rows[s.name] = row;
        return row;
      }));
      this.circuits.hidden = !this.panes[0].result.states.some((s) => s.circuit === 'open');
    }

    listFields() {
      const input = this.inputs.field;
      input.replaceChildren(element('option', { value: '' }, 'part'),
        ...this.fieldsNow().map((f) => element('option', { value: f.key }, f.title)));
      input.value = this.options.field;
    }

    circuit(value) {
      this.options.circuit = value;
      const other = this.state.circuit === 'driven' ? this.state.name
        : this.state.name.replace(/short|open/, value);
      this.listStates(); this.select(other);
      this.options.circuit = value; this.words();
    }

    play() { this.options.playing = !this.options.playing; this.words(); }
    pause() { if (this.options.playing) this.play(); }

    cut(axis, at) {
      const box = this.panes[0].result.box, k = 'xyz'.indexOf(axis);
      this.inputs.axis.value = axis;
      this.cutRow.hidden = axis === 'none';
      if (k >= 0) {
        const [low, high] = [box.low[k] * 1e3, box.high[k] * 1e3], input = this.inputs.at;
        if (this.options.cut.axis !== axis) {
          Object.assign(input, { min: low, max: high, step: (high - low) / 200 });
          at = 0.5 * (low + high); input.value = at;
        }
        this.inputs.atText.textContent = (+at).toFixed(2) + ' mm';
      }
      this.options.cut = { axis, at: at === undefined ? 0 : at };
      for (const pane of this.panes) pane.slice();
      this.words(); this.draw();
    }

    step(way) {
      const names = Object.keys(this.rows), k = names.indexOf(this.state.name);
      this.select(names[(k + way + names.length) % names.length]);
    }

    keys() {
      const press = {
        ' ': () => this.play(), '[': () => this.step(-1), ']': () => this.step(1), h: () => this.look('home'),
        o: () => this.circuit(this.options.circuit === 'open' ? 'short' : 'open'),
        m: () => this.inputs.mesh.click(), r: () => this.inputs.rest.click(),
        c: () => {
          const all = ['', ...this.fieldsNow().map((f) => f.key)];
          this.inputs.field.value = this.options.field = all[(all.indexOf(this.options.field) + 1) % all.length];
          this.refresh();
        },
        ArrowRight: () => this.turn(PHASE_STEP), ArrowLeft: () => this.turn(-PHASE_STEP),
      };
      const listen = (where) => where.addEventListener('keydown', (e) => {
        if (e.ctrlKey || e.metaKey || e.altKey || !press[e.key]) return;
        e.preventDefault(); press[e.key]();
      });
      listen(this.renderer.domElement);
      this.stateList.addEventListener('keydown', (e) => {
        const way = { ArrowDown: 1, ArrowUp: -1 }[e.key];
        if (way) { e.preventDefault(); this.step(way); }
      });
    }

    turn(degrees) {
      this.pause();
      this.options.phase = (this.options.phase + degrees * Math.PI / 180 + 2 * Math.PI) % (2 * Math.PI);
      this.draw();
    }

    pointer() {
      const canvas = this.renderer.domElement;
      canvas.addEventListener('pointermove', (e) => { if (!e.buttons) this.read(e.offsetX, e.offsetY); });
      canvas.addEventListener('pointerdown', (e) => { if (e.pointerType !== 'mouse') this.read(e.offsetX, e.offsetY); });
      canvas.addEventListener('pointerleave', (e) => { if (e.pointerType === 'mouse') this.tip.hidden = true; });
    }

    read(x, y) {
      const T = window.THREE, share = this.width / this.panes.length;
      const pane = this.panes[Math.min(Math.floor(x / share), this.panes.length - 1)];
      const inside = ((x % share) / share) * 2 - 1;
      const from = new T.Vector3(inside, 1 - 2 * y / this.height, -1).unproject(this.camera);
      const to = new T.Vector3(inside, 1 - 2 * y / this.height, 1).unproject(this.camera).sub(from).normalize();
      const hit = pane.hit([from.x, from.y, from.z], [to.x, to.y, to.z]);
      this.tip.hidden = !hit;
      if (!hit) return null;
      const found = pane.reading(hit), lines = [element('b', {}, found.region.title)];
      const field = pane.field || (pane.state.moves ? pane.result.fields[0] : null);
      if (field && !(found.region.rigid && field.source > 2)) {
        const number = readable(found.value, field);
        lines.push(element('br'), `${field.title}${pane.field ? '' : ' now'}: ${number.value} ${number.unit}`);
      }
      lines.push(element('br'), element('span', { class: 'tv-dim' },
        'at rest ' + found.rest.map((v) => (v * 1e3).toFixed(2)).join(', ') + ' mm'));
      this.tip.replaceChildren(...lines);
      this.tip.style.left = Math.min(x + 14, this.width - 190) + 'px';
      this.tip.style.top = Math.max(Math.min(y + 14, this.height - 70), 4) + 'px';
      return found;
    }
  }

  /** A value in SI as people read it: engineering prefix, three digits. */
  function readable(value, field) {
    if (field.unit === '1' || !field.unit) return { value: value.toExponential(2), unit: '' };
    const size = Math.abs(value);
    const power = size > 0 ? Math.max(-4, Math.min(3, Math.floor(Math.log10(size * 1.0000001) / 3))) : 0;
    const prefix = { '-4': 'p', '-3': 'n', '-2': 'µ', '-1': 'm', 0: '', 1: 'k', 2: 'M', 3: 'G' }[power];
    return { value: (value / 10 ** (3 * power)).toPrecision(3).replace('-', '−'), unit: prefix + field.unit };
  }

  /** The state of another model that goes with one: same circuit and class, same place in it. */
  function pairing(state, mine, theirs) {
    const keys = state.kind === 'mode' ? ['circuit', 'motion'] : ['kind'];
    const alike = (all) => all.filter((s) => keys.every((key) => s[key] === state[key]));
    return alike(theirs)[alike(mine).indexOf(state)] || null;
  }

  function able() {
    if (typeof DecompressionStream === 'undefined' || location.hash === '#nowebgl') return false;
    try { return !!document.createElement('canvas').getContext('webgl2'); } catch (e) { return false; }
  }

  async function mount(root) {
    const payload = JSON.parse(document.getElementById(root.dataset.payload).textContent);
    const stills = root.querySelector('.tv-stills');
    if (!able()) {
      const why = typeof DecompressionStream === 'undefined' ? 'is too old to unpack the data' : 'has no WebGL 2';
      root.querySelector('.tv-why').textContent = `This browser ${why}, so nothing moves here. Still pictures instead:`;
      stills.hidden = false; root.dataset.ready = 'stills';
      return null;
    }
    const view = new View(root, payload);
    await view.start();
    root.dataset.ready = 'moving';
    return view;
  }

  window.addEventListener('DOMContentLoaded', async () => {
    for (const root of document.querySelectorAll('.tv')) {
      const view = await mount(root);
      const wanted = new URLSearchParams(location.hash.slice(1));
      if (view) {
        root.tactgen = view;
        if (wanted.get('state')) view.select(wanted.get('state'));
        if (wanted.get('field')) { view.options.field = wanted.get('field'); view.listFields(); view.refresh(); }
        if (wanted.get('beside')) { view.choose(0, +wanted.get('beside')); view.inputs.other.value = wanted.get('beside'); view.look('home'); }
        if (wanted.get('cut')) view.cut(wanted.get('cut'));
        if (wanted.get('length')) view.stretch(+wanted.get('length'));
        if (wanted.get('phase')) { view.pause(); view.options.phase = +wanted.get('phase') * Math.PI / 180; view.draw(); }
      }
    }
  });
})();
