"use strict";
// Draws the page's plots with uPlot from the data beside them, and lists and opens strikes. Fetches nothing.
(() => {
  const all = JSON.parse(document.getElementById("strikes")?.textContent ?? '{"strikes":{},"rejects":[],"models":[],"logs":[],"sessions":[]}');
  const form = document.querySelector("form.filters");
  const wanted = { session: "", split: "", low: NaN, high: NaN, model: all.models[0]?.[0] ?? "" };
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const make = (tag, attributes = {}, ...children) => {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
      else if (value !== undefined && value !== false) element.setAttribute(name, value);
    }
    element.append(...children.filter((child) => child !== undefined && child !== null));
    return element;
  };
  const cm = (metres) => (metres === undefined ? "" : (100 * metres).toFixed(2) + " cm");
  const titleOf = (model) => (all.models.find(([name]) => name === model) ?? ["", { nominal: "nominal simulator", sysid: "identified simulator", effect: "identified + effect" }[model] ?? model])[1];

  // Which strikes the filters let through.
  const isWanted = (place) => {
    const row = all.strikes[place];
    if (wanted.split === "rejected") return false;
    return (wanted.session === "" || row.session === Number(wanted.session))
      && (wanted.split === "" || row.split === wanted.split || (wanted.split === "train" && row.split === "validation"))
      && !(row.speed < wanted.low) && !(row.speed > wanted.high);
  };
  const describe = (place) => {
    const row = all.strikes[place];
    const error = row.errors?.[wanted.model];
    return `${row.id} · ${all.sessions[row.session]} · ${row.speed.toFixed(2)} m/s at ${row.angle.toFixed(2)} rad`
      + (error === undefined ? "" : ` · misses by ${cm(error)}`);
  };

  // ------------------------------------------------------------------------------------------------ plots

  const tip = make("div", { class: "tip", role: "status", "aria-live": "polite", hidden: "" });
  document.body.append(tip);
  const FONT = "12px system-ui, sans-serif";
  // Labels beside the axes, and names beyond them, in pixels.
  const AXES = { left: 42, bottom: 26, name: 16 };
  const drawn = [];

  const range = (values, given) => {
    if (given) return given;
    let low = Infinity, high = -Infinity;
    for (const value of values) if (value !== null && Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
    if (low > high) return [0, 1];
    const space = Math.max(0.06 * (high - low), 1e-9);
    return [low - space, high + space];
  };

  class Figure {
    constructor(element, plot, onOpen) {
      this.element = element;
      this.plot = plot;
      this.onOpen = onOpen;
      this.at = -1;
      this.holder = make("div", { class: "holder" });
      element.append(this.holder);
      this.hasStrikes = plot.series.some((series) => series.strikes?.length);
      const named = plot.series.filter((series) => series.name);
      if (named.length > 0 && !plot.hides_legend) {
        element.append(make("p", { class: "legend" }, ...named.map((series) => make("span", { class: "entry" },
          make("span", { class: "swatch " + series.kind, style: `--hue:var(--${series.colour})${series.is_pale ? ";opacity:0.55" : ""}` }), series.name))));
      }
      if (this.hasStrikes) {
        this.holder.tabIndex = 0;
        this.holder.setAttribute("role", "application");
        this.holder.setAttribute("aria-label", (element.getAttribute("aria-label") ?? "plot") + "; arrows go from strike to strike, Enter opens one");
        this.holder.addEventListener("keydown", (event) => this.key(event));
        this.holder.addEventListener("blur", () => this.leave());
      } else {
        this.holder.setAttribute("role", "img");
        this.holder.setAttribute("aria-label", element.getAttribute("aria-label") ?? "plot");
      }
      this.draw();
    }

    ranges(width) {
      const { plot } = this;
      const x = range(plot.series.flatMap((series) => series.x), plot.x_range);
      const y = range(plot.series.flatMap((series) => series.y), plot.y_range);
      const inner = Math.max(width - AXES.left - AXES.name - 16, 60);
      let height = Math.round(Math.min(Math.max(0.62 * width, 190), 340));
      if (plot.is_map) {
        const wanted = inner * (y[1] - y[0]) / Math.max(x[1] - x[0], 1e-9);
        const tall = Math.min(Math.max(wanted, 160), 420);
        height = Math.round(tall + AXES.bottom + AXES.name + 12);
        const scale = Math.max((x[1] - x[0]) / inner, (y[1] - y[0]) / tall);
        const around = ([low, high], pixels) => [(low + high - scale * pixels) / 2, (low + high + scale * pixels) / 2];
        return { x: around(x, inner), y: around(y, tall), height };
      }
      return { x, y, height };
    }

    draw() {
      const { plot } = this;
      const width = Math.floor(this.holder.clientWidth);
      if (width < 40) return;
      this.width = width;
      this.chart?.destroy();
      const { x, y, height } = this.ranges(width);
      const axis = (label, size) => ({
        label, size, labelSize: AXES.name, labelFont: FONT, font: FONT, gap: 4,
        stroke: () => css("ink"), grid: { stroke: () => css("line"), width: 1 }, ticks: { show: false },
        values: (_, splits) => splits.map((value) => value === null ? "" : String(Number(value.toPrecision(6)))),
      });
      const options = {
        width, height, mode: 2, padding: [12, 16, 0, 0],
        legend: { show: false }, cursor: { show: false },
        scales: { x: { time: false, range: x, distr: plot.log_x ? 3 : 1 }, y: { range: y } },
        axes: [{ ...axis(plot.x, AXES.bottom), ...(plot.counts_x ? { incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500] } : {}), ...(plot.log_x ? { filter: (_, splits) => splits.map((value) => [1, 2, 5].includes(Number(value.toPrecision(2).replace(/[.0]|e.*/g, ""))) ? value : null) } : {}) }, { ...axis(plot.y, AXES.left), scale: "y" }],
        hooks: { drawClear: [(u) => this.shade(u)] },
        series: [{}, ...plot.series.map((series, place) => ({
          facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }],
          paths: (u) => { this.series(u, plot.series[place]); return null; },
        }))],
      };
      this.chart = new uPlot(options, [null, ...plot.series.map((series) => [series.x, series.y])], this.holder);
      const over = this.chart.over;
      over.addEventListener("mousemove", (event) => this.point(event.offsetX, event.offsetY));
      over.addEventListener("mouseleave", () => this.leave());
      over.addEventListener("click", () => { if (this.at >= 0) this.open(); });
      this.marker = make("div", { class: "marker", hidden: "" });
      over.append(this.marker);
    }

    shade(u) {
      const { shaded } = this.plot;
      if (!shaded) return;
      const [x0, x1, y0, y1] = shaded;
      const left = u.valToPos(x0, "x", true), right = u.valToPos(x1, "x", true);
      const top = u.valToPos(y1, "y", true), bottom = u.valToPos(y0, "y", true);
      const { ctx, bbox } = u;
      ctx.save();
      ctx.beginPath(); ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height); ctx.clip();
      ctx.fillStyle = css("table");
      ctx.fillRect(left, top, right - left, bottom - top);
      ctx.restore();
    }

    series(u, series) {
      const { ctx, bbox } = u;
      const ratio = devicePixelRatio || 1;
      const at = (i) => [u.valToPos(series.x[i], "x", true), u.valToPos(series.y[i], "y", true)];
      const isNone = (i) => series.x[i] === null || series.y[i] === null;
      ctx.save();
      ctx.beginPath(); ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height); ctx.clip();
      ctx.strokeStyle = ctx.fillStyle = css(series.colour);
      ctx.globalAlpha = series.is_pale ? 0.45 : 0.85;
      ctx.lineWidth = (series.kind === "line" ? 2 : 1.2) * ratio;
      if (series.kind === "line") {
        ctx.beginPath();
        let isDown = false;
        for (let i = 0; i < series.x.length; i++) {
          if (isNone(i)) { isDown = false; continue; }
          const [x, y] = at(i);
          if (isDown) ctx.lineTo(x, y); else ctx.moveTo(x, y);
          isDown = true;
        }
        ctx.stroke();
      } else if (series.kind === "arrows") {
        for (let i = 0; i + 1 < series.x.length; i += 2) {
          if (!isWanted(series.strikes[i / 2])) continue;
          const [x0, y0] = at(i), [x1, y1] = at(i + 1);
          const angle = Math.atan2(y1 - y0, x1 - x0), barb = Math.min(6 * ratio, 0.4 * Math.hypot(x1 - x0, y1 - y0));
          ctx.beginPath(); ctx.moveTo(x0, y0); ctx.lineTo(x1, y1);
          for (const side of [-2.6, 2.6]) { ctx.moveTo(x1, y1); ctx.lineTo(x1 + barb * Math.cos(angle + side), y1 + barb * Math.sin(angle + side)); }
          ctx.stroke();
        }
      } else {
        for (let i = 0; i < series.x.length; i++) {
          if (isNone(i) || (series.strikes?.length && !isWanted(series.strikes[i]))) continue;
          const [x, y] = at(i);
          const radius = (series.radii?.[i] ?? 2.6) * ratio;
          ctx.beginPath();
          if (series.kind === "crosses") {
            const arm = 5 * ratio;
            ctx.moveTo(x - arm, y - arm); ctx.lineTo(x + arm, y + arm); ctx.moveTo(x - arm, y + arm); ctx.lineTo(x + arm, y - arm);
            ctx.stroke();
          } else {
            ctx.arc(x, y, radius, 0, 2 * Math.PI);
            if (series.kind === "rings") ctx.stroke(); else ctx.fill();
          }
        }
      }
      ctx.restore();
    }

    // Every point of a strike that is shown, in pixels.
    points() {
      const found = [];
      for (const series of this.plot.series) {
        const each = series.kind === "arrows" ? 2 : 1;
        (series.strikes ?? []).forEach((strike, place) => {
          const i = place * each + each - 1;
          if (series.x[i] === null || series.y[i] === null || !isWanted(strike)) return;
          found.push({ strike, x: this.chart.valToPos(series.x[i], "x"), y: this.chart.valToPos(series.y[i], "y") });
        });
      }
      return found;
    }

    point(x, y) {
      if (!this.hasStrikes) return;
      let best = null, far = 14;
      for (const point of this.points()) {
        const apart = Math.hypot(point.x - x, point.y - y);
        if (apart < far) { far = apart; best = point; }
      }
      if (best) this.show(best); else this.leave();
    }

    show(point) {
      this.at = point.strike;
      this.marker.hidden = false;
      this.marker.style.left = point.x + "px";
      this.marker.style.top = point.y + "px";
      tip.textContent = describe(point.strike);
      tip.hidden = false;
      const box = this.chart.over.getBoundingClientRect();
      const left = Math.min(box.left + point.x + 12, innerWidth - tip.offsetWidth - 8);
      tip.style.left = Math.max(left, 8) + scrollX + "px";
      tip.style.top = box.top + point.y + 14 + scrollY + "px";
    }

    leave() {
      this.at = -1;
      tip.hidden = true;
      if (this.marker) this.marker.hidden = true;
    }

    key(event) {
      const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };
      if (event.key === "Enter" && this.at >= 0) { event.preventDefault(); this.open(); return; }
      if (event.key === "Escape") this.leave();
      if (!(event.key in steps)) return;
      event.preventDefault();
      const points = this.points().sort((a, b) => a.x - b.x || a.y - b.y);
      if (points.length === 0) return;
      this.cursor = ((this.cursor ?? -1) + steps[event.key] + points.length) % points.length;
      this.show(points[this.cursor]);
    }

    open() { const { at } = this; this.leave(); openStrike(at); }
  }

  const figure = (element, plot) => { const made = new Figure(element, plot); drawn.push(made); return made; };
  for (const element of document.querySelectorAll("figure.plot")) {
    figure(element, JSON.parse(element.querySelector("script").textContent));
  }
  const redraw = () => drawn.forEach((made) => made.draw());
  let waiting = 0;
  addEventListener("resize", () => { cancelAnimationFrame(waiting); waiting = requestAnimationFrame(() => drawn.forEach((made) => { if (Math.floor(made.holder.clientWidth) !== made.width) made.draw(); })); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  // On paper colours are those of the light page: the style sheet says so for print, canvases must be drawn with them.
  addEventListener("beforeprint", () => { document.documentElement.classList.add("printed"); redraw(); });
  addEventListener("afterprint", () => { document.documentElement.classList.remove("printed"); redraw(); });

  // On a narrow screen what is behind the answers is folded; on paper nothing is.
  const foldable = [...document.querySelectorAll("details.more")];
  const isNarrow = matchMedia("(max-width: 560px)");
  const fold = (isOpen) => foldable.forEach((details) => { details.open = isOpen; });
  fold(!isNarrow.matches);
  isNarrow.addEventListener("change", () => fold(!isNarrow.matches));
  addEventListener("beforeprint", () => fold(true));

  // There a row of words is a block, and each of its cells says what it is.
  for (const table of document.querySelectorAll("table:has(td.words)")) {
    const headings = [...table.querySelectorAll("thead th")].map((heading) => heading.textContent);
    for (const row of table.querySelectorAll("tbody tr")) {
      [...row.cells].forEach((cell, place) => { if (place && headings[place]) cell.dataset.heading = headings[place]; });
    }
  }

  // ------------------------------------------------------------------------------------------------ one strike

  const dialog = document.querySelector("dialog.strike");
  const when = (time) => time > 1e8 ? new Date(1000 * time).toISOString().replace("T", " ").slice(0, 23) + " UTC" : time.toFixed(3) + " s by the log's clock";
  const sums = (steps, unit) => { let sum = 0; return steps.map((step) => (sum += step) * unit); };
  const fact = (name, value) => [make("dt", {}, name), make("dd", {}, value)];
  const begin = (heading) => {
    dialog.replaceChildren(make("button", { class: "close", "aria-label": "close", onclick: () => dialog.close() }, "×"), make("h2", {}, heading));
  };

  function openStrike(place) {
    const row = all.strikes[place];
    if (!dialog || !row) return;
    begin(row.id);
    const errors = all.models.filter(([model]) => row.errors?.[model] !== undefined);
    dialog.append(make("dl", {},
      ...fact("log", `${all.logs[row.log]}, strike ${row.index}`), ...fact("time", when(row.time)), ...fact("session", all.sessions[row.session]),
      ...fact("command", `${row.speed.toFixed(3)} m/s at ${row.angle.toFixed(3)} rad`),
      ...fact("from", `(${row.from[0].toFixed(3)}, ${row.from[1].toFixed(3)}) m`),
      ...fact("stopped", row.stop ? `(${row.stop[0].toFixed(3)}, ${row.stop[1].toFixed(3)}) m` : "not at rest by itself"),
      ...fact("part", { test: "held out", train: "learnt from", validation: "ended training" }[row.split] ?? row.split),
      ...errors.flatMap(([model, title]) => fact(title, "misses by " + cm(row.errors[model])))));
    if (row.track) {
      const t = sums(row.track.t, 1e-3), x = sums(row.track.x, 1e-4), y = sums(row.track.y, 1e-4);
      const worlds = Object.entries(row.track.worlds).map(([model, [dx, dy]]) => ({ model, x: sums(dx, 1e-4), y: sums(dy, 1e-4) }));
      const measured = { name: "measured", colour: "measured", kind: "dots", x, y, strikes: [] };
      const lines = worlds.map(({ model, x, y }) => ({ name: titleOf(model), colour: model, kind: "line", x, y, strikes: [] }));
      const apart = worlds.map(({ model, x: sx, y: sy }) => ({ name: titleOf(model), colour: model, kind: "line", strikes: [], x: t, y: x.map((value, i) => 1000 * Math.hypot(value - sx[i], y[i] - sy[i])) }));
      const columns = make("div", { class: "columns" });
      dialog.append(columns);
      if (!dialog.open) dialog.showModal();
      const add = (plot, said) => { const element = make("figure", { class: "plot", "aria-label": said }, make("figcaption", {}, said)); columns.append(element); return () => new Figure(element, plot); };
      const plain = { title: "", is_map: false, log_x: false, y_range: null, x_range: null, shaded: null };
      const track = add({ ...plain, is_map: true, x: "x in m", y: "y in m", series: [...lines, measured] }, "track, measured and simulated");
      const top = Math.max(...apart.filter(({ colour }) => colour !== "nominal" || apart.length === 1).flatMap(({ y }) => y), 1);
      // What leaves the plot says how far it goes.
      for (const line of apart) {
        const most = Math.max(...line.y);
        if (most > 1.1 * top) line.name += `, up to ${most.toFixed(0)} mm`;
      }
      const residual = add({ ...plain, x: "s since first motion", y: "apart in mm", y_range: [0, 1.1 * top], series: apart }, "residual, frame by frame");
      // Only now that both have their place is each as wide as it will be.
      track();
      residual();
    } else {
      dialog.append(make("p", { class: "note" }, "No frame of it was kept."));
    }
    if (!dialog.open) dialog.showModal();
    dialog.querySelector(".close").focus();
  }

  function openRejected(reject) {
    begin(`${reject.log}, strike ${reject.index}: rejected`);
    dialog.append(make("dl", {}, ...fact("reason", reject.reason), ...fact("what was seen", reject.detail), ...fact("time", when(reject.time))));
    dialog.showModal();
  }
  dialog?.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });

  // ------------------------------------------------------------------------------------------------ the list

  const PAGE = 12;
  let first = 0, by = "error", isUp = false;
  const list = document.querySelector("div.list");
  const value = {
    strike: (row) => row.id, session: (row) => all.sessions[row.session], speed: (row) => row.speed, angle: (row) => row.angle,
    part: (row) => row.split, error: (row) => row.errors?.[wanted.model] ?? -1,
  };
  const opens = (cell, open) => make("button", { class: "open", onclick: open }, cell);

  function show() {
    if (!list) return;
    const isRejected = wanted.split === "rejected";
    let rows;
    if (isRejected) {
      rows = all.rejects.map((reject) => ({ cells: [opens(`${reject.log} ${reject.index}`, () => openRejected(reject)), reject.reason, reject.detail] }));
    } else {
      const places = Object.keys(all.strikes).map(Number).filter(isWanted);
      const of = (place) => value[by](all.strikes[place]);
      places.sort((a, b) => { const [one, other] = [of(a), of(b)]; const order = one < other ? -1 : one > other ? 1 : a - b; return isUp ? order : -order; });
      rows = places.map((place) => {
        const row = all.strikes[place];
        return { cells: [opens(row.id, () => openStrike(place)), all.sessions[row.session], row.speed.toFixed(2), row.angle.toFixed(2),
          { test: "held out", train: "learnt from", validation: "ended training" }[row.split] ?? row.split, cm(row.errors?.[wanted.model])] };
      });
    }
    first = Math.min(first, Math.max(0, PAGE * Math.floor((rows.length - 1) / PAGE)));
    const heads = isRejected ? [["log, strike"], ["reason"], ["what was seen"]]
      : [["strike", "strike"], ["session", "session"], ["m/s", "speed"], ["rad", "angle"], ["part", "part"], ["misses by", "error"]];
    const head = make("tr", {}, ...heads.map(([text, key]) => make("th", { scope: "col", "aria-sort": key === by ? (isUp ? "ascending" : "descending") : undefined },
      key ? make("button", { class: "sort", onclick: () => { isUp = key === by ? !isUp : false; by = key; first = 0; show(); } }, text + (key === by ? (isUp ? " ▲" : " ▼") : "")) : text)));
    const body = rows.slice(first, first + PAGE).map(({ cells }) => make("tr", {}, ...cells.map((cell) => make("td", {}, cell))));
    const go = (text, to, is) => { const button = make("button", { type: "button", onclick: () => { first = to; show(); } }, text); button.disabled = !is; return button; };
    list.replaceChildren(make("div", { class: "wide", tabindex: 0, role: "region", "aria-label": "strikes" }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...body))),
      make("p", { class: "pages" }, go("‹ before", first - PAGE, first > 0), ` ${rows.length ? first + 1 : 0}–${Math.min(first + PAGE, rows.length)} of ${rows.length} `, go("next ›", first + PAGE, first + PAGE < rows.length)));
    form.elements.count.value = `${rows.length} shown`;
  }

  form?.addEventListener("submit", (event) => event.preventDefault());
  form?.addEventListener("input", () => {
    for (const name of ["session", "split", "model"]) wanted[name] = form.elements[name].value;
    for (const name of ["low", "high"]) wanted[name] = form.elements[name].valueAsNumber;
    first = 0;
    show();
    redraw();
  });
  if (form) show();
  document.documentElement.dataset.drawn = String(drawn.filter((made) => made.chart).length);
})();
