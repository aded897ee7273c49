/* Put into a page with the viewer: drives every control, reads back what is drawn, and writes what
 * came of it into the page.
 */
(function () {
  'use strict';

  const errors = [];
  window.addEventListener('error', (e) => errors.push(String(e.message)));
  window.addEventListener('unhandledrejection', (e) => errors.push(String(e.reason)));

  /* The position as the shader has it, one point a pixel: what the self-test reads back. */
  const PROBE_VERTEX = `
    precision highp float;
    in vec3 position; in vec3 re; in vec3 im;
    uniform vec2 turn; uniform float enlarge;
    out vec3 vMoved;
    void main() {
      vMoved = position + enlarge * (re * turn.x - im * turn.y);
      gl_Position = vec4(0.0, 0.0, 0.0, 1.0); gl_PointSize = 1.0;
    }`;
  const PROBE_FRAGMENT = `
    precision highp float; in vec3 vMoved; out vec4 colour;
    void main() { colour = vec4(vMoved, 1.0); }`;

  /** Where the shader puts a point at phases (rad): drawn into floats, one pixel each. */
  function probe(view, paneNumber, point, phases) {
    const T = window.THREE, pane = view.panes[paneNumber];
    const target = new T.WebGLRenderTarget(1, 1, {
      type: T.FloatType, minFilter: T.NearestFilter, magFilter: T.NearestFilter, depthBuffer: false });
    const geometry = new T.BufferGeometry();
    for (const [name, values] of [['position', pane.constant.position], ['re', pane.moving.re], ['im', pane.moving.im]]) {
      geometry.setAttribute(name, new T.BufferAttribute(values.slice(3 * point, 3 * point + 3), 3));
    }
    const uniforms = { turn: { value: new T.Vector2() }, enlarge: { value: pane.enlargement() } };
    const points = new T.Points(geometry, new T.RawShaderMaterial({
      glslVersion: T.GLSL3, vertexShader: PROBE_VERTEX, fragmentShader: PROBE_FRAGMENT, uniforms }));
    points.frustumCulled = false;
    const scene = new T.Scene(); scene.add(points);
    const out = phases.map((phase) => {
      uniforms.turn.value.set(Math.cos(phase), Math.sin(phase));
      view.renderer.setScissorTest(false);
      view.renderer.setRenderTarget(target); view.renderer.clear();
      view.renderer.render(scene, view.camera);
      const pixel = new Float32Array(4);
      view.renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel);
      return Array.from(pixel.slice(0, 3));
    });
    view.renderer.setRenderTarget(null); target.dispose();
    return out;
  }

  /** A number that changes when the picture does. */
  function fingerprint(view) {
    view.draw();
    const gl = view.renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
    const pixels = new Uint8Array(4 * w * h);
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let sum = 2166136261, painted = 0;
    for (let k = 0; k < pixels.length; k += 4) {
      if (pixels[k + 3]) painted += 1;
      sum = Math.imul(sum ^ (pixels[k] | pixels[k + 1] << 8 | pixels[k + 2] << 16), 16777619);
    }
    return { sum: sum >>> 0, painted };
  }

  /** Drive every control and write what came of it into the page, for the program's own tests. */
  async function selftest(view) {
    const report = { errors: errors, requests: performance.getEntriesByType('resource').length };
    const phases = [...Array(8).keys()].map((k) => k * Math.PI / 4);
    view.pause(); view.options.phase = 0;
    const first = fingerprint(view);
    report.painted = first.painted;
    report.states = [];
    for (const state of view.panes[0].result.states) {
      view.select(state.name);
      report.states.push({ name: state.name, text: state.text, sum: fingerprint(view).sum,
        enlarge: view.panes[0].enlargement(), tip: probe(view, 0, view.panes[0].result.tip, phases) });
    }
    view.select(view.panes[0].result.states[0].name);
    const changes = report.changes = {};
    const differs = (name, change, back) => {
      const before = fingerprint(view).sum;
      change(); changes[name] = fingerprint(view).sum !== before;
      if (back) back();
    };
    const send = (key) => view.renderer.domElement.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true }));
    const moves = !!view.inputs.amplitude, several = view.results[0].states.length > 1;
    const drag = (key, value) => { if (!view.inputs[key]) return; view.inputs[key].value = value; view.inputs[key].dispatchEvent(new Event('input')); };
    const set = (key, value) => { view.inputs[key].value = value; view.inputs[key].dispatchEvent(new Event('change')); };
    if (moves) {
      differs('phase', () => drag('phase', 90), () => drag('phase', 0));
      differs('amplitude', () => drag('amplitude', 2), () => drag('amplitude', 1));
      differs('key arrow', () => { send('ArrowRight'); send('ArrowRight'); }, () => drag('phase', 0));
    }
    differs('explode', () => drag('explode', 1), () => drag('explode', 0));
    differs('mesh', () => view.inputs.mesh.click(), () => view.inputs.mesh.click());
    differs('rest', () => { drag('phase', 0); view.inputs.rest.click(); }, () => view.inputs.rest.click());
    for (const axis of ['x', 'y', 'z']) differs('cut ' + axis, () => set('axis', axis), () => set('axis', 'none'));
    set('field', '');
    for (const field of view.fieldsNow()) differs('colour ' + field.key, () => set('field', field.key), () => set('field', ''));
    differs('key c', () => send('c'), () => set('field', ''));
    differs('key m', () => send('m'), () => send('m'));
    if (several) differs('key ]', () => send(']'), () => send('['));
    if (view.inputs.other) {
      differs('two results', () => set('other', view.results.length - 1));
      report.captions = [...view.captions.children].map((c) => c.textContent);
      set('other', -1);
    }
    if (view.inputs.length) {
      view.pause();
      drag('phase', 0);
      const count = view.results.find((r) => r.lengths).lengths.at.length;
      differs('length', () => drag('length', 0), () => view.inputs.ownLength.click());
      report.lengths = [0, Math.floor(count / 3), count - 1].map((k) => {
        drag('length', k);
        return { k, sum: fingerprint(view).sum, height: view.panes[0].result.box.height, said: view.inputs.lengthText.textContent,
          tip: probe(view, 0, view.panes[0].result.tip, [0])[0], enlarge: view.panes[0].enlargement(),
          label: view.renderer.domElement.getAttribute('aria-label'),
          texts: Object.fromEntries(view.panes[0].result.states.map((s) => [s.name, s.text])) };
      });
      view.inputs.ownLength.click();
    }
    if (several) {
      const circuit = view.options.circuit;
      send('o'); report.opened = view.state.name; send('o');
      changes['key o'] = view.options.circuit === circuit && report.opened !== view.state.name;
    }
    for (const from of ['x', 'y', 'z', 'upright']) differs('look ' + from, () => view.look(from));
    view.look('home');
    // the animation advances by itself
    if (moves) {
      const phase = view.options.phase;
      view.play();
      await new Promise((resolve) => setTimeout(resolve, 600));
      changes.animation = view.options.phase !== phase;
      view.pause();
    }
    // pointing at the middle of the device gives a value
    view.select(view.panes[0].result.states[0].name);
    set('field', view.fieldsNow()[0].key);
    drag('amplitude', 0);
    const found = view.read(view.width / 2, view.height / 2);
    report.reading = found ? { region: found.region.name, rest: found.rest, text: view.tip.textContent } : null;
    report.label = view.renderer.domElement.getAttribute('aria-label');
    report.images = [...document.images].filter((i) => !i.alt).length;
    report.unlabelled = [...document.querySelectorAll('input,select,button')].filter(
      (i) => !(i.textContent || i.getAttribute('aria-label') || i.closest('label'))).length;
    const written = document.createElement('pre');
    written.id = 'selftest'; written.textContent = JSON.stringify(report);
    document.body.append(written);
  }

  window.addEventListener('DOMContentLoaded', () => {
    const waiting = setInterval(() => {
      const view = document.querySelector('.tv').tactgen;
      if (!view) return;
      clearInterval(waiting);
      selftest(view);
    }, 50);
  });
})();
