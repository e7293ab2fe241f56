// SPDX-License-Identifier: Apache-2.0
// The charts, the pictures and the tables of a study's page. `results` is study.json.
"use strict";
(function () {
  const results = JSON.parse(document.getElementById("results").textContent);
  const pictures = JSON.parse(document.getElementById("pictures").textContent);
  const byId = (id) => document.getElementById(id);
  const state = { scene: 0, colour: -1, across: 0, left: "reference", right: "image0" };
  const HUES = {
    light: ["#2257c5", "#c2410c", "#0f7b52", "#8b3fb4", "#a16207", "#0e7490", "#be185d", "#57606f"],
    dark: ["#7ea8ff", "#ff9d66", "#58d0a0", "#cf9bf2", "#e3bd58", "#5cc8dd", "#ff86b6", "#a9b2c1"],
  };
  const SHAPES = ["circle", "rect", "triangle", "rectRot", "star", "crossRot"];
  let charts = [];

  function element(name, text, attributes) {
    const made = document.createElement(name);
    if (text !== undefined && text !== null) made.textContent = text;
    for (const key of Object.keys(attributes || {})) made.setAttribute(key, attributes[key]);
    return made;
  }

  // ---- Numbers as text --------------------------------------------------------------------------

  const known = (x) => typeof x === "number" && isFinite(x);

  function brief(x, digits) {
    if (!known(x)) return "–";
    if (x === 0) return "0";
    const size = Math.abs(x);
    if (size >= 1e9) return +(x / 1e9).toPrecision(digits || 3) + " G";
    if (size >= 1e6) return +(x / 1e6).toPrecision(digits || 3) + " M";
    if (size >= 1e4) return +(x / 1e3).toPrecision(digits || 3) + " k";
    if (size >= 1e-3) return String(+x.toPrecision(digits || 3));
    return x.toExponential((digits || 3) - 1).replace("e-", "e−");
  }

  function valueLabel(value) {
    if (value === null || value === "") return "–";
    const x = Number(value);
    return isFinite(x) ? brief(x, 4) : value;
  }

  function shortLabel(point) {
    const named = results.points[point];
    const text = named.values.filter((v) => v !== null && v !== "").map(valueLabel).join(" · ");
    return text || named.label;
  }

  const mean = (list) => list.reduce((a, b) => a + b, 0) / list.length;

  // ---- What was found ---------------------------------------------------------------------------

  // The points of the scene that is shown, with means over the seeds.
  function found() {
    const all = results.results.filter((r) => r.scene === state.scene);
    return all.map(function (r) {
      const good = r.runs.filter((x) => x.done && x.status === 0 && x.signal === 0);
      const of = (name) => good.map((x) => x[name]).filter(known);
      const average = (name) => (of(name).length ? mean(of(name)) : null);
      const spread = (name) => (of(name).length ? [Math.min(...of(name)), Math.max(...of(name))] : [null, null]);
      return {
        point: r.point, image: r.image, first: r.first_pass, runs: r.runs, good: good,
        label: results.points[r.point].label, values: results.points[r.point].values,
        relmse: average("relmse"), spread: spread("relmse"),
        firstRelmse: average("first_pass_relmse"), firstSpread: spread("first_pass_relmse"),
        seconds: average("seconds"), cpu: average("cpu_seconds"), memory: average("memory_bytes"),
        samples: average("samples"), photons: average("photon_paths"), records: average("records"),
        lookupError: average("lookup_error"),
        stages: results.stages.map((_, i) => (good.length ? mean(good.map((x) => x.stages[i])) : 0)),
      };
    });
  }

  // The values of an axis in the order of the file, or ascending if all are numbers.
  function axisValues(axis) {
    const values = [];
    for (const p of results.points)
      if (p.values[axis] !== null && p.values[axis] !== "" && !values.includes(p.values[axis]))
        values.push(p.values[axis]);
    return isNumeric(values) ? values.sort((a, b) => a - b) : values;
  }

  const isNumeric = (values) => values.length > 0 && values.every((v) => isFinite(Number(v)));

  // ---- Colours ----------------------------------------------------------------------------------

  const theme = () => document.documentElement.dataset.theme;
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // Numbers have a ramp of hues, names have separate ones.
  function colourOf(axis, value) {
    const list = HUES[theme()];
    if (axis < 0) return list[0];
    if (value === null || value === "") return css("--soft");
    const values = axisValues(axis), at = Math.max(values.indexOf(value), 0);
    if (!isNumeric(values) || values.length < 4) return list[at % list.length];
    const t = at / (values.length - 1);
    const light = theme() === "dark" ? 70 - 8 * t : 42 + 4 * t;
    return "hsl(" + Math.round(255 - 230 * t) + " 70% " + light + "%)";
  }

  // The axis that colours the lines of a chart whose x axis is `x`.
  function colourAxis(x) {
    if (state.colour >= 0 && state.colour !== x) return state.colour;
    if (state.colour === -2) return -1;
    const several = results.axes.map((_, i) => i).filter((i) => i !== x && axisValues(i).length > 1);
    const names = several.filter((i) => !isNumeric(axisValues(i)));
    return names.length ? names[0] : several.length ? several[0] : -1;
  }

  function keys(axis, extra) {
    const list = element("ul", null, { class: "keys" });
    const add = function (text, colour) {
      const item = element("li"), mark = element("i");
      mark.style.background = colour;
      item.append(mark, document.createTextNode(text));
      list.append(item);
    };
    if (axis >= 0)
      for (const v of axisValues(axis)) add(results.axes[axis] + " " + valueLabel(v), colourOf(axis, v));
    for (const [text, colour] of extra || []) add(text, colour);
    return list;
  }

  // ---- Charts -----------------------------------------------------------------------------------

  // Bars from the least to the largest value of the seeds.
  const spreadBars = {
    id: "spreadBars",
    beforeDatasetsDraw(chart) {
      const { ctx, chartArea: area, scales } = chart;
      if (!scales.y || chart.config.type === "bar") return;
      ctx.save();
      ctx.lineWidth = 1;
      chart.data.datasets.forEach(function (set, index) {
        const meta = chart.getDatasetMeta(index);
        if (meta.hidden) return;
        ctx.strokeStyle = set.borderColor;
        set.data.forEach(function (d, i) {
          if (!known(d.low) || d.low <= 0 || d.low === d.high || !meta.data[i]) return;
          const x = meta.data[i].x;
          const y0 = Math.min(scales.y.getPixelForValue(d.low), area.bottom);
          const y1 = Math.max(scales.y.getPixelForValue(d.high), area.top);
          ctx.beginPath();
          ctx.moveTo(x, y0); ctx.lineTo(x, y1);
          ctx.moveTo(x - 3, y0); ctx.lineTo(x + 3, y0);
          ctx.moveTo(x - 3, y1); ctx.lineTo(x + 3, y1);
          ctx.stroke();
        });
      });
      ctx.restore();
    },
  };

  function tooltipLines(item) {
    const p = item.raw.row;
    const lines = ["relMSE " + brief(p.relmse) + (known(p.image.relmse_error) ? " ± " + brief(p.image.relmse_error, 2) : "")];
    if (known(p.image.bias2)) lines.push("bias² " + brief(p.image.bias2) + ", variance " + brief(p.image.variance));
    if (known(p.firstRelmse)) lines.push("first pass " + brief(p.firstRelmse));
    lines.push(brief(p.seconds) + " s, " + brief(p.memory / 1048576) + " MB");
    return lines;
  }

  // The next of the numbers that axes end with, below or above x > 0.
  function niceEnd(x, up) {
    const power = Math.pow(10, Math.floor(Math.log10(x))), lead = x / power, list = [1, 1.5, 2, 3, 5, 7, 10];
    const below = list.filter((k) => k <= lead * 1.0001), above = list.filter((k) => k >= lead * 0.9999);
    return power * (up ? above[0] : below[below.length - 1]);
  }

  // The numbers at which a logarithmic axis has ticks.
  function logTicks(least, most) {
    const ratio = most / least, ticks = [];
    const leads = ratio > 300 ? [1] : ratio > 12 ? [1, 2, 5] : ratio > 4 ? [1, 2, 3, 5, 7] : [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9];
    for (let e = Math.floor(Math.log10(least)); e <= Math.log10(most); e++)
      for (const k of leads) {
        const value = Number((k * Math.pow(10, e)).toPrecision(6));
        if (value >= least * 0.9999 && value <= most * 1.0001) ticks.push({ value });
      }
    return ticks;
  }

  function scaleOf(title, values) {
    const numbers = values.filter((v) => known(v) && v > 0);
    const scale = {
      type: numbers.length ? "logarithmic" : "linear",
      title: { display: true, text: title, color: css("--soft") },
      grid: { color: css("--grid") }, border: { color: css("--line") },
      ticks: { color: css("--soft"), maxRotation: 0, autoSkipPadding: 10, callback: (value) => brief(value) },
    };
    if (!numbers.length) return scale;
    scale.min = niceEnd(Math.min(...numbers) / 1.05, false);
    scale.max = niceEnd(Math.max(...numbers) * 1.05, true);
    scale.afterBuildTicks = (axis) => { axis.ticks = logTicks(scale.min, scale.max); };
    return scale;
  }

  // All values that the lines of a chart have, with their bars.
  const extent = (sets) => sets.flatMap((set) => set.data.flatMap((d) => [d.y, d.low, d.high]));

  // Numbers of which one is 0 have a linear axis or, if they differ much, equal distances: a
  // logarithmic axis has no 0.
  const LINEAR_RATIO = 20;

  function axisScale(axis) {
    const values = axisValues(axis), numbers = values.map(Number);
    const positive = isNumeric(values) && numbers[0] > 0;
    const scale = scaleOf(results.axes[axis], positive ? numbers : []);
    if (positive) {
      scale.min = numbers[0] / 1.15;
      scale.max = Math.max(...numbers) * 1.15;
      scale.afterBuildTicks = (s) => { s.ticks = values.length <= 8 ? numbers.map((value) => ({ value })) : logTicks(scale.min, scale.max); };
    }
    if (isNumeric(values)) scale.ticks.callback = (value) => brief(value, 4);
    const sizes = numbers.map(Math.abs).filter((x) => x > 0);
    if (!isNumeric(values) || (!positive && Math.max(...sizes) > LINEAR_RATIO * Math.min(...sizes))) {
      scale.type = "category";
      scale.labels = isNumeric(values) ? numbers : values;
      scale.offset = true;
      if (isNumeric(values)) scale.ticks.callback = (i) => brief(numbers[i], 4);
      else delete scale.ticks.callback;
    }
    return scale;
  }

  // Points are visited by arrow keys; Enter selects the one that is active.
  function listenToKeys(canvas, chart) {
    let at = -1;
    canvas.addEventListener("keydown", function (event) {
      const all = [];
      chart.data.datasets.forEach((set, datasetIndex) => set.data.forEach((_, index) => all.push({ datasetIndex, index })));
      if (!all.length) return;
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (step) {
        at = (at + step + all.length) % all.length;
        const shown = chart.getDatasetMeta(all[at].datasetIndex).data[all[at].index];
        chart.setActiveElements([all[at]]);
        chart.tooltip.setActiveElements([all[at]], { x: shown.x, y: shown.y });
        chart.update("none");
      } else if (event.key === "Enter" && at >= 0) {
        select(chart.data.datasets[all[at].datasetIndex].data[all[at].index].row.point);
      } else {
        return;
      }
      event.preventDefault();
    });
  }

  function draw(holder, label, config, legend, height) {
    const plot = element("div", null, { class: "plot" });
    const canvas = element("canvas", null, { tabindex: "0", role: "img", "aria-label": label });
    if (height) plot.style.height = height + "px";
    plot.append(canvas);
    holder.append(plot);
    if (legend && legend.children.length) holder.append(legend);
    const options = config.options;
    Object.assign(options, {
      responsive: true, maintainAspectRatio: false, animation: false,
      interaction: { mode: "nearest", intersect: false, axis: "xy" },
      onClick(event, active, chart) {
        if (active.length) select(chart.data.datasets[active[0].datasetIndex].data[active[0].index].row.point);
      },
    });
    options.plugins = Object.assign({ legend: { display: false } }, options.plugins);
    options.plugins.tooltip = Object.assign({
      displayColors: false, padding: 10, filter: (_, index) => index === 0,
      callbacks: { title: (items) => (items.length ? items[0].raw.row.label : ""), label: tooltipLines },
    }, options.plugins.tooltip);
    const chart = new Chart(canvas, config);
    listenToKeys(canvas, chart);
    charts.push(chart);
    return chart;
  }

  // One line per combination of all axes but x; `y` gives [value, least, largest] or null.
  function lines(rows, x, y, style) {
    const sets = new Map(), by = colourAxis(x);
    for (const row of rows) {
      const value = y(row), at = x < 0 ? row.seconds : row.values[x];
      if (!value || !known(value[0]) || value[0] <= 0 || at === null || at === "") continue;
      const others = row.values.filter((_, i) => i !== x && (x >= 0 || i !== lineAxis()));
      const key = JSON.stringify(others);
      const colour = colourOf(by, by < 0 ? null : row.values[by]);
      if (!sets.has(key))
        sets.set(key, Object.assign({
          data: [], borderColor: colour, backgroundColor: colour, borderWidth: 1.6, pointRadius: 4,
          pointHoverRadius: 6, pointStyle: SHAPES[0], fill: false, clip: 8,
        }, style));
      const numeric = x < 0 || isNumeric(axisValues(x));
      sets.get(key).data.push({ x: numeric ? Number(at) : at, y: value[0], low: value[1], high: value[2],
        limit: value[3], row });
    }
    for (const set of sets.values()) {
      set.data.sort((a, b) => (x < 0 ? lineOrder(a) - lineOrder(b) : order(x, a) - order(x, b)));
      if (style && style.hollow) set.pointBackgroundColor = css("--panel");
      set.pointStyle = set.data.map((d) => (d.limit ? "triangle" : "circle"));
      set.pointRotation = set.data.map((d) => (d.limit ? 180 : 0));
    }
    // Points that nothing joins belong to other charts, unless all are such.
    const all = [...sets.values()], joined = all.filter((set) => new Set(set.data.map((d) => d.x)).size > 1);
    return x >= 0 && joined.length ? joined : all;
  }

  // The axis along which points of the chart of time are joined: the one with the most numbers.
  function lineAxis() {
    let best = -1, most = 1;
    results.axes.forEach(function (_, i) {
      const values = axisValues(i);
      if (isNumeric(values) && values.length > most && i !== colourAxis(-1)) { best = i; most = values.length; }
    });
    return best;
  }
  const order = (axis, d) => axisValues(axis).indexOf(d.row.values[axis]);
  const lineOrder = (d) => (lineAxis() < 0 ? d.x : order(lineAxis(), d));

  const noise = () => results.scenes[state.scene].reference_noise;
  const relmse = (row) => (known(row.relmse) ? [row.relmse, ...row.spread] : null);

  function chartTime(rows) {
    const holder = byId("chart-time");
    holder.replaceChildren();
    const sets = lines(rows, -1, relmse);
    const seconds = sets.flatMap((set) => set.data.map((d) => d.x));
    draw(holder, "Error against seconds, both logarithmic", {
      type: "line", data: { datasets: sets }, plugins: [spreadBars],
      options: { scales: { x: scaleOf("seconds", seconds), y: scaleOf("relMSE", extent(sets)) } },
    }, keys(colourAxis(-1)));
  }

  function chartAxes(rows) {
    const holder = byId("axes");
    holder.replaceChildren();
    results.axes.forEach(function (name, axis) {
      if (axisValues(axis).length < 2) return;
      const box = element("div", null, { class: "chart" });
      box.append(element("h3", name));
      holder.append(box);
      const sets = lines(rows, axis, relmse);
      draw(box, "Error against " + name, {
        type: "line", data: { datasets: sets }, plugins: [spreadBars],
        options: { scales: { x: axisScale(axis), y: scaleOf("relMSE", extent(sets)) } },
      }, keys(colourAxis(axis)));
    });
  }

  // The bias, or the limit below which it is.
  function bias(row) {
    const b = row.image.bias2, error = row.image.bias2_error;
    if (!known(b)) return null;
    if (known(error) && b < 2 * error) return [Math.max(b, 0) + 2 * error, null, null, true];
    return b > 0 ? [b, known(error) ? Math.max(b - error, b / 100) : null, known(error) ? b + error : null] : null;
  }

  function chartBias(rows) {
    const holder = byId("chart-bias"), x = state.across;
    holder.replaceChildren();
    if (results.seeds < 2 || !results.axes.length) {
      holder.append(element("p", "This needs two seeds or more, and an axis.", { class: "note" }));
      return;
    }
    const variance = lines(rows, x, (r) => (known(r.image.variance) ? [r.image.variance] : null));
    const squares = lines(rows, x, bias, { borderDash: [5, 4], hollow: true });
    const sets = variance.concat(squares);
    draw(holder, "Bias and variance against " + results.axes[x], {
      type: "line", data: { datasets: sets }, plugins: [spreadBars],
      options: { scales: { x: axisScale(x), y: scaleOf("in relMSE", sets.flatMap((set) => set.data.map((d) => d.y))) } },
    }, keys(colourAxis(x)));
  }

  function chartFirst(rows) {
    const holder = byId("chart-first"), x = state.across;
    holder.replaceChildren();
    const any = rows.some((r) => known(r.firstRelmse));
    holder.closest("section").hidden = !any;
    if (!any || !results.axes.length) return;
    const seen = (r) => (known(r.firstRelmse) ? [r.firstRelmse, ...r.firstSpread] : null);
    const sets = lines(rows, x, relmse).concat(lines(rows, x, seen, { borderDash: [5, 4], hollow: true }));
    draw(holder, "Error of first pass and final image against " + results.axes[x], {
      type: "line", data: { datasets: sets }, plugins: [spreadBars],
      options: { scales: { x: axisScale(x), y: scaleOf("relMSE", extent(sets)) } },
    }, keys(colourAxis(x)));
  }

  function bars(holder, label, title, rows, datasets, legend) {
    const phone = holder.clientWidth < 420;
    const category = { type: "category", labels: rows.map((r) => shortLabel(r.point)), grid: { display: false },
      border: { color: css("--line") },
      ticks: { color: css("--soft"), autoSkip: false, font: { size: phone ? 10 : 11 },
        callback(value) { const text = this.getLabelForValue(value); return text.length > 34 ? text.slice(0, 33) + "…" : text; } } };
    const amount = { title: { display: true, text: title, color: css("--soft") }, beginAtZero: true,
      grid: { color: css("--grid") }, ticks: { color: css("--soft") }, border: { color: css("--line") }, stacked: true };
    category.stacked = true;
    holder.replaceChildren(element("h3", label));
    draw(holder, label, {
      type: "bar", data: { labels: category.labels, datasets },
      options: { indexAxis: "y", scales: { x: amount, y: category },
        plugins: { tooltip: { callbacks: { title: (items) => (items.length ? items[0].raw.row.label : ""),
          label: (item) => (item.dataset.label || "") + " " + brief(item.raw.x) + " " + title } } } },
    }, legend, 70 + 19 * rows.length);
  }

  function chartStages(rows) {
    const list = HUES[theme()];
    const used = results.stages.map((name, i) => i).filter((i) => rows.some((r) => r.stages[i] > 1e-3));
    const set = (label, colour, x) => ({ label, backgroundColor: colour, barPercentage: 0.85,
      categoryPercentage: 0.9, data: rows.map((row) => ({ x: x(row), y: shortLabel(row.point), row })) });
    bars(byId("chart-stages"), "Seconds of each stage", "s", rows,
      used.map((i) => set(results.stages[i], list[i % list.length], (r) => r.stages[i])),
      keys(-1, used.map((i) => [results.stages[i], list[i % list.length]])));
    bars(byId("chart-memory"), "Peak memory", "MB", rows,
      [set("memory", list[0], (r) => (known(r.memory) ? r.memory / 1048576 : 0))]);
  }

  // ---- Tables -----------------------------------------------------------------------------------

  const COLUMNS = [
    ["relMSE", (r) => r.relmse], ["±", (r) => r.image.relmse_error], ["bias²", (r) => r.image.bias2],
    ["± ", (r) => r.image.bias2_error], ["variance", (r) => r.image.variance],
    ["mean − 1, %", (r) => (known(r.image.mean_ratio) ? 100 * (r.image.mean_ratio - 1) : null)],
    ["first pass", (r) => r.firstRelmse],
    ["lookup, %", (r) => (known(r.lookupError) ? 100 * r.lookupError : null)], ["s", (r) => r.seconds], ["CPU s", (r) => r.cpu],
    ["MB", (r) => (known(r.memory) ? r.memory / 1048576 : null)], ["samples", (r) => r.samples],
    ["photon paths", (r) => r.photons], ["records", (r) => r.records],
  ];
  let sorted = { column: -1, down: false };

  function tableHead(table, names, sortable) {
    const head = element("thead"), row = element("tr");
    names.forEach(function (name, i) {
      const cell = element("th", sortable ? null : name, { scope: "col" });
      if (i < results.axes.length || name === "point") cell.className = "text";
      if (sortable) {
        const button = element("button", name, { type: "button" });
        button.addEventListener("click", function () {
          sorted = { column: i, down: sorted.column === i && !sorted.down };
          tableAll(found());
        });
        cell.append(button);
        if (sorted.column === i) cell.setAttribute("aria-sort", sorted.down ? "descending" : "ascending");
      }
      row.append(cell);
    });
    head.append(row);
    table.replaceChildren(head);
    const body = element("tbody");
    table.append(body);
    return body;
  }

  function tableRow(row, columns) {
    const line = element("tr");
    for (const v of row.values) line.append(element("td", valueLabel(v), { class: "text" }));
    if (!results.axes.length) line.append(element("td", row.label, { class: "text" }));
    for (const [, value] of columns) line.append(element("td", brief(value(row))));
    if ("image" + row.point === state.right) line.className = "selected";
    return line;
  }

  const axisNames = () => (results.axes.length ? results.axes : ["point"]);

  function tableBest(rows) {
    const good = rows.filter((r) => known(r.relmse) && known(r.seconds));
    const best = good.filter((r) => !good.some((o) => o !== r && o.seconds <= r.seconds && o.relmse <= r.relmse));
    best.sort((a, b) => a.seconds - b.seconds);
    const columns = COLUMNS.filter(([name]) => ["s", "relMSE", "±", "bias²", "variance", "MB"].includes(name));
    const body = tableHead(byId("best"), axisNames().concat(columns.map((c) => c[0])), false);
    for (const row of best) body.append(tableRow(row, columns));
  }

  function tableAll(rows) {
    const axes = axisNames().length;
    const value = (r) => (sorted.column < axes ? order(sorted.column, { row: r }) : COLUMNS[sorted.column - axes][1](r));
    if (sorted.column >= 0)
      rows.sort((a, b) => (sorted.down ? -1 : 1) * ((known(value(a)) ? value(a) : 1e99) - (known(value(b)) ? value(b) : 1e99)));
    const body = tableHead(byId("all"), axisNames().concat(COLUMNS.map((c) => c[0])), true);
    for (const row of rows) {
      const line = tableRow(row, COLUMNS), link = element("td", null, { class: "link" });
      const show = element("button", "picture", { type: "button" });
      show.addEventListener("click", () => { select(row.point); byId("h-pictures").scrollIntoView(); });
      link.append(show);
      line.append(link);
      const command = element("tr"), cell = element("td", null, { class: "command text", colspan: axes + COLUMNS.length + 1 });
      const failed = row.runs.find((x) => x.done && (x.status !== 0 || x.signal !== 0));
      cell.append(element("code", row.runs[0].command));
      if (failed) cell.append(element("strong", " failed: " + (failed.message || (failed.signal ? "signal " + failed.signal : "status " + failed.status))));
      command.append(cell);
      body.append(line, command);
    }
  }

  // ---- Pictures ---------------------------------------------------------------------------------

  // The picture of a choice: its image and its difference from the reference.
  function pictureOf(choice) {
    const scene = pictures[state.scene];
    if (choice === "reference") return { image: scene.reference, difference: null };
    const p = scene.points[Number(choice.replace(/\D+/, ""))];
    if (choice.startsWith("image")) return { image: p.image, difference: p.difference };
    const from = p.first_pass_of === undefined ? p : scene.points[p.first_pass_of];
    return { image: from.first_pass, difference: from.first_pass_difference };
  }

  function fillPickers() {
    const options = [["reference", "reference"]];
    pictures[state.scene].points.forEach((p, i) => { if (p.image) options.push(["image" + i, results.points[i].label]); });
    pictures[state.scene].points.forEach((p, i) => { if (p.first_pass) options.push(["first_pass" + i, "first pass of " + results.points[i].label]); });
    for (const side of ["left", "right"]) {
      byId(side).replaceChildren(...options.map(([value, text]) => element("option", text, { value })));
      if (!options.some(([value]) => value === state[side])) state[side] = options[Math.min(side === "left" ? 0 : 1, options.length - 1)][0];
      byId(side).value = state[side];
    }
  }

  function showSplit() {
    const at = byId("split").value;
    byId("right-image").style.clipPath = "inset(0 0 0 " + at + "%)";
    byId("divider").style.left = at + "%";
  }

  // Blue is darker than the reference, red is brighter.
  function colourDifference(d, out, at) {
    const t = Math.min(Math.abs(d), 1), end = d < 0 ? [31, 95, 208] : [207, 58, 43], none = [244, 244, 242];
    for (let c = 0; c < 3; c++) out[at + c] = none[c] + (end[c] - none[c]) * t;
    out[at + 3] = 255;
  }

  function showDifference() {
    const canvas = byId("difference"), source = pictureOf(state.right).difference;
    const scene = pictures[state.scene], context = canvas.getContext("2d", { willReadFrequently: true });
    canvas.width = scene.width;
    canvas.height = scene.height;
    byId("difference-caption").textContent = source
      ? "Right minus reference, over the reference (" + byId("scale").selectedOptions[0].textContent + " is full colour)"
      : "The reference is on the right, so there is no difference.";
    canvas.setAttribute("aria-label", "Difference from the reference of " + byId("right").selectedOptions[0].textContent);
    if (!source) return;
    const image = new Image();
    image.onload = function () {
      context.drawImage(image, 0, 0);
      const data = context.getImageData(0, 0, canvas.width, canvas.height), full = Number(byId("scale").value);
      for (let i = 0; i < data.data.length; i += 4) {
        const root = (data.data[i] - 128) / 127;
        colourDifference((Math.sign(root) * root * root) / full, data.data, i);
      }
      context.putImageData(data, 0, 0);
    };
    image.src = source;
  }

  function showPictures() {
    for (const side of ["left", "right"]) {
      state[side] = byId(side).value;
      const image = byId(side + "-image");
      image.src = pictureOf(state[side]).image;
      image.alt = byId(side).selectedOptions[0].textContent;
    }
    byId("slider-caption").textContent = "Left: " + byId("left").selectedOptions[0].textContent + ". Right: " + byId("right").selectedOptions[0].textContent + ".";
    showSplit();
    showDifference();
    tableAll(found());
  }

  function select(point) {
    if (!pictures[state.scene].points[point].image) return;
    byId("right").value = "image" + point;
    showPictures();
  }

  function drag(event) {
    const box = byId("slider").getBoundingClientRect();
    byId("split").value = (100 * (event.clientX - box.left)) / box.width;
    showSplit();
  }

  // ---- The page ---------------------------------------------------------------------------------

  function warn(rows) {
    const lines = [], failed = rows.reduce((n, r) => n + r.runs.filter((x) => x.done && (x.status !== 0 || x.signal !== 0)).length, 0);
    const missing = rows.reduce((n, r) => n + r.runs.filter((x) => !x.done).length, 0);
    const least = Math.min(...rows.map((r) => r.relmse).filter((x) => known(x) && x > 0));
    if (missing) lines.push("The study is not complete: " + missing + " renders of this scene are missing.");
    if (failed) lines.push(failed + " renders of this scene failed; the table says why.");
    const uncompared = rows.some((r) => r.good.some((x) => !known(x.relmse)));
    if (uncompared) lines.push("Images of this scene cannot be compared with its reference; they have no errors.");
    if (known(noise()) && noise() > least)
      lines.push("The reference's own noise, " + brief(noise(), 2) + " in relMSE, is larger than the least error, " + brief(least, 2) + ". It is subtracted, but the smallest errors are uncertain: give the reference more samples.");
    if (!known(noise()) && !uncompared) lines.push("The noise of this reference is not known, so it is part of all errors.");
    byId("warnings").textContent = lines.join("\n");
  }

  function drawAll() {
    for (const chart of charts) chart.destroy();
    charts = [];
    const rows = found();
    warn(rows);
    tableBest(rows);
    chartTime(rows);
    chartAxes(rows);
    chartBias(rows);
    chartFirst(rows);
    chartStages(rows);
  }

  function showScene(scene) {
    state.scene = scene;
    [...byId("scenes").children].forEach((button, i) => {
      button.setAttribute("aria-checked", String(i === scene));
      button.tabIndex = i === scene ? 0 : -1;
    });
    drawAll();
    fillPickers();
    showPictures();
  }

  function setTheme(name) {
    document.documentElement.dataset.theme = name;
  }

  function start() {
    const preferred = window.matchMedia("(prefers-color-scheme: dark)");
    setTheme(preferred.matches ? "dark" : "light");
    document.title = results.title || "Study";
    byId("title").textContent = results.title || "Study";
    byId("question").textContent = results.question;
    const facts = [results.points.length + " points", results.scenes.length + " scenes", results.seeds + " seeds",
      results.reference_spp ? "reference: " + results.reference_integrator + ", " + results.reference_spp + " samples per pixel" : "references from files",
      results.mask_emission ? "pixels that see an emitter are left out" : "all pixels are compared", "satin " + results.satin];
    byId("facts").append(...facts.map((text) => element("li", text)));
    results.scenes.forEach(function (scene, i) {
      const button = element("button", scene.name, { type: "button", role: "radio" });
      button.addEventListener("click", () => showScene(i));
      button.addEventListener("keydown", function (event) {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (!step) return;
        const next = (i + step + results.scenes.length) % results.scenes.length;
        showScene(next);
        byId("scenes").children[next].focus();
      });
      byId("scenes").append(button);
    });
    const several = results.axes.map((_, i) => i).filter((i) => axisValues(i).length > 1);
    byId("colour").append(element("option", "automatic", { value: -1 }), ...several.map((i) => element("option", results.axes[i], { value: i })), element("option", "nothing", { value: -2 }));
    byId("across").append(...several.map((i) => element("option", results.axes[i], { value: i })));
    state.across = several.find((i) => isNumeric(axisValues(i))) ?? several[0] ?? 0;
    byId("across").value = state.across;
    byId("colour").addEventListener("change", () => { state.colour = Number(byId("colour").value); drawAll(); });
    byId("across").addEventListener("change", () => { state.across = Number(byId("across").value); drawAll(); });
    byId("theme").addEventListener("click", () => { setTheme(theme() === "dark" ? "light" : "dark"); drawAll(); });
    preferred.addEventListener("change", () => { setTheme(preferred.matches ? "dark" : "light"); drawAll(); });
    for (const id of ["left", "right", "scale"]) byId(id).addEventListener("change", showPictures);
    byId("split").addEventListener("input", showSplit);
    byId("slider").addEventListener("pointerdown", function (event) { byId("slider").setPointerCapture(event.pointerId); drag(event); });
    byId("slider").addEventListener("pointermove", (event) => { if (event.buttons) drag(event); });
    byId("picture-note").textContent = "Pictures of the first seed, " + pictures[0].width + " pixels wide, all with the exposure of the reference. Drag the boundary, or move it with the arrow keys.";
    let before = theme();
    window.addEventListener("beforeprint", () => { before = theme(); setTheme("light"); drawAll(); });
    window.addEventListener("afterprint", () => { setTheme(before); drawAll(); });
    Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
    Chart.defaults.font.size = 12;
    showScene(0);
  }

  start();
})();
