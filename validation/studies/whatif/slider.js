// Sliders over a study's axes: values with bars at each point, and a curve with a band.
(function () {
  const data = JSON.parse(document.getElementById("study-data").textContent);
  const box = document.getElementById("sliders"), answers = document.getElementById("answers");
  const chosen = document.getElementById("quantity"), curve = document.getElementById("curve");
  const stops = data.axes.map((a) => a.numeric && a.values.slice().sort((x, y) => x - y));
  const now = data.axes.map((a, n) => (a.numeric ? a.values.indexOf(stops[n][Math.floor(stops[n].length / 2)]) : 0));
  const colours = ["#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9", "#1d2733"];

  const prefixes = { "-15": "f", "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M", 9: "G" };
  function scaled(size, unit) {
    if (unit === "" || unit === "1" || !isFinite(size) || size === 0) return [1, unit === "1" ? "" : unit];
    const e = Math.max(-15, Math.min(9, 3 * Math.floor(Math.log10(Math.abs(size)) / 3)));
    return [10 ** -e, prefixes[e] + unit];
  }
  const digits = (value, most) => String(Number(value.toPrecision(most)));  // 15, and not 15.000
  // flat place of a point; the last axis runs fastest
  const flat = (at) => at.reduce((sum, place, n) => sum * data.axes[n].values.length + place, 0);

  data.axes.forEach((axis, n) => {
    const line = document.createElement("p"), label = document.createElement("label");
    label.textContent = axis.key + " ";
    if (axis.numeric) {
      const input = document.createElement("input"), shown = document.createElement("output");
      Object.assign(input, { type: "range", min: 0, max: stops[n].length - 1, id: "slider-" + n });
      input.value = stops[n].indexOf(axis.values[now[n]]);
      const say = () => {
        const value = axis.values[now[n]], [factor, unit] = scaled(value, axis.unit), text = digits(value * factor, 5) + " " + unit;
        shown.textContent = " " + text; input.setAttribute("aria-valuetext", text);
      };
      input.addEventListener("input", () => { now[n] = axis.values.indexOf(stops[n][input.value]); say(); draw(); });
      say(); label.append(input, shown);
    } else {
      const select = document.createElement("select");
      axis.values.forEach((v, i) => select.add(new Option(v, i)));
      select.addEventListener("change", () => { now[n] = Number(select.value); draw(); });
      label.append(select);
    }
    line.append(label); box.append(line);
  });
  data.quantities.forEach((q, i) => chosen.add(new Option(q.label, i)));
  chosen.addEventListener("change", draw);

  function draw() {
    const cell = (row, tag, text) => { const c = document.createElement(tag); c.textContent = text; row.append(c); };
    answers.replaceChildren();
    const head = answers.insertRow();
    ["quantity", ...data.models.map((m) => m.model)].forEach((text) => cell(head, "th", text));
    data.quantities.forEach((q) => {
      const row = answers.insertRow();
      cell(row, "td", q.label);
      data.models.forEach((m) => cell(row, "td", q.name in m.numbers ? m.numbers[q.name].text[flat(now)] : "-"));
    });
    plot(data.quantities[Number(chosen.value) || 0]);
  }

  function plot(q) {
    const along = data.axes.findIndex((a) => a.numeric), width = 900, height = 320, left = 90, bottom = 46;
    const lines = data.models.filter((m) => m.numbers[q.name]).map((m) => {
      const of = m.numbers[q.name];
      return { model: m.model, points: data.axes[along].values.map((x, i) => {
        const k = flat(now.map((place, n) => (n === along ? i : place)));
        return { x: x, y: of.value[k], bar: of.bar[k] || 0, here: i === now[along] };
      }).filter((p) => p.y !== null).sort((p, q) => p.x - q.x) };
    }).filter((line) => line.points.length);
    const every = lines.flatMap((line) => line.points);
    curve.replaceChildren();
    curve.setAttribute("aria-label", every.length
      ? q.label + " over " + data.axes[along].key + " by " + lines.map((line) => line.model).join(", ")
      : "no value of " + q.label);
    if (!every.length) return;
    const xs = every.map((p) => p.x), low = every.map((p) => p.y - p.bar), high = every.map((p) => p.y + p.bar);
    const x0 = Math.min(...xs), x1 = Math.max(...xs);
    let y0 = Math.min(...low), y1 = Math.max(...high);
    if (y0 === y1) { y0 -= 0.5 * Math.abs(y0) || 1; y1 += 0.5 * Math.abs(y1) || 1; }
    const px = (x) => left + ((x - x0) / (x1 - x0 || 1)) * (width - left - 20);
    const py = (y) => height - bottom - ((y - y0) / (y1 - y0)) * (height - bottom - 40);
    const add = (kind, set, text) => {
      const made = document.createElementNS("http://www.w3.org/2000/svg", kind);
      Object.entries(set).forEach(([name, value]) => made.setAttribute(name, value));
      if (text) made.textContent = text;
      curve.append(made);
    };
    const [fx, ux] = scaled(x1, data.axes[along].unit), [fy, uy] = scaled(Math.max(Math.abs(y0), Math.abs(y1)), q.unit);
    for (let i = 0; i <= 4; i++) {
      const x = x0 + (i / 4) * (x1 - x0), y = y0 + (i / 4) * (y1 - y0);
      add("line", { x1: left, x2: width - 20, y1: py(y), y2: py(y), stroke: "#d8dfe6" });
      add("text", { x: left - 8, y: py(y) + 4, "text-anchor": "end", "font-size": 13 }, digits(y * fy, 4));
      add("text", { x: px(x), y: height - bottom + 18, "text-anchor": "middle", "font-size": 13 }, digits(x * fx, 4));
    }
    add("text", { x: (left + width) / 2, y: height - 6, "text-anchor": "middle", "font-size": 13 },
      data.axes[along].key + (ux ? " (" + ux + ")" : ""));
    add("text", { x: 8, y: 14, "font-size": 13 }, q.label + (uy ? " (" + uy + ")" : ""));
    lines.forEach((line, n) => {
      const colour = colours[n % colours.length], points = line.points;
      const band = [...points.map((p) => [p.x, p.y + p.bar]), ...[...points].reverse().map((p) => [p.x, p.y - p.bar])];
      add("polygon", { points: band.map(([x, y]) => px(x) + "," + py(y)).join(" "), fill: colour, opacity: 0.2 });
      add("polyline", { points: points.map((p) => px(p.x) + "," + py(p.y)).join(" "), fill: "none", stroke: colour, "stroke-width": 1.8 });
      const here = points.find((p) => p.here);
      if (here) add("circle", { cx: px(here.x), cy: py(here.y), r: 5, fill: colour });
      const end = width - 24 - 120 * (lines.length - 1 - n);
      add("line", { x1: end - 108, x2: end - 88, y1: 10, y2: 10, stroke: colour, "stroke-width": 4 });
      add("text", { x: end - 82, y: 14, "font-size": 13 }, line.model);
    });
  }
  draw();
})();
