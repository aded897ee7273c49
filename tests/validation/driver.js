// Put first into a page by a test: it notes every complaint, does what the test says once all is
// loaded, and writes what it found into the page, where the dumped document has it.
(() => {
  const report = { errors: [], found: {} };
  const note = (what) => report.errors.push(String(what));
  window.addEventListener('error', (e) => note(e.message || `${e.target.tagName} was not loaded`), true);
  window.addEventListener('unhandledrejection', (e) => note(e.reason));
  document.addEventListener('securitypolicyviolation', (e) => note(`refused ${e.blockedURI}`));
  for (const kind of ['error', 'warn']) console[kind] = (...words) => note(words.join(' '));

  // pictures are drawn when the test says so: a browser without a window draws few, and when it likes
  const waiting = [];
  let clock = 0;
  window.requestAnimationFrame = (picture) => waiting.push(picture);

  const seen = (node) => node.checkVisibility({ visibilityProperty: true });
  const all = (what) => [...document.querySelectorAll(what)].filter(seen);

  // WCAG 2.2: relative luminance, and the contrast of two colours as a browser computes them
  const parts = (colour) => colour.match(/[\d.]+/g).map(Number);
  const luminance = (colour) => parts(colour).slice(0, 3)
    .map((v) => v / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
    .reduce((sum, c, n) => sum + c * [0.2126, 0.7152, 0.0722][n], 0);
  const contrast = (a, b) => {
    const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  };
  const opaque = (colour) => parts(colour).length === 3 || parts(colour)[3] === 1;
  function ground(node) {
    for (let at = node; at; at = at.parentElement) {
      const colour = getComputedStyle(at).backgroundColor;
      if (opaque(colour)) return colour;
    }
    return matchMedia('(prefers-color-scheme: dark)').matches ? 'rgb(18, 18, 18)' : 'rgb(255, 255, 255)';
  }
  // the least contrast of words, and whose it is; the browser's own controls are left to it
  function leastContrast() {
    const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    let least = { contrast: 21, words: '' };
    while (walk.nextNode()) {
      const words = walk.currentNode.textContent.trim(), holder = walk.currentNode.parentElement;
      if (!words || !seen(holder) || holder.closest('select, button')) continue;
      const style = getComputedStyle(holder);
      const own = contrast(holder.closest('svg') ? style.fill : style.color, ground(holder));
      if (own < least.contrast) least = { contrast: own, words };
    }
    return least;
  }

  // what has no name for those who do not see it
  const named = (node) => node.getAttribute('aria-label') || node.getAttribute('alt')
    || node.closest('label')?.textContent.trim() || (node.tagName === 'BUTTON' && node.textContent.trim());
  const unnamed = () => all('img, figure > svg, canvas, input, select, button')
    .filter((node) => !named(node)).map((node) => node.outerHTML.slice(0, 80));

  const one = (what) => document.querySelector(what);
  const tools = {
    one, all,
    text: (what) => one(what).textContent,
    set: (what, value, event = 'input') => { one(what).value = value; one(what).dispatchEvent(new Event(event)); },
    press: (what, key) => one(what).dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true })),
    // so many pictures are drawn, one each 16 ms of the page's time
    draw: (count = 1) => {
      for (let n = 0; n < count; n++) { clock += 16; waiting.splice(0).forEach((picture) => picture(clock)); }
    },
  };
  window.addEventListener('load', async () => {
    try { await act(tools, report.found); } catch (error) { note(error.stack || error); }
    report.requests = performance.getEntriesByType('resource').map((e) => e.name).filter((name) => !name.startsWith('data:'));
    report.unnamed = unnamed();
    report.contrast = leastContrast();
    const written = document.createElement('pre');
    written.id = 'report'; written.textContent = JSON.stringify(report);
    document.body.append(written);
  });
  async function act(page, found) {
    const { one, all, text, set, press, draw } = page; // eslint-disable-line no-unused-vars
    /* what the test says */
  }
})();
