// Draws the charts of the page: series by uPlot, everything else by Observable Plot.
(() => {
  "use strict";
  const charts = JSON.parse(document.getElementById("dn-data").textContent).charts;
  const kColours = 7;
  const kSeriesHeight = 260;
  const kTallestMap = 640;
  const kFewPoints = 400;

  const variable = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const colour = (k) => `var(--c${k % kColours})`;
  const unique = (values) => [...new Set(values)];
  const pointsOf = (curve) => curve.x.map((x, k) => ({ x, y: curve.y[k], label: curve.label }));
  const shortened = (text, most) => (text.length > most ? text.slice(0, most - 1) + "…" : text);

  function swatches(labels) {
    const list = document.createElement("div");
    list.className = "swatches";
    labels.forEach((label, k) => {
      const item = list.appendChild(document.createElement("span"));
      item.appendChild(document.createElement("i")).style.background = colour(k);
      item.append(label);
    });
    return list;
  }

  // Returns the index of the nearest value of a series: curves do not share their abscissae.
  function nearestIndex(plot, series, index) {
    const y = plot.data[series];
    for (let step = 0; step < y.length; ++step) {
      if (y[index - step] != null) return index - step;
      if (y[index + step] != null) return index + step;
    }
    return index;
  }

  function seriesOptions(chart) {
    const series = [{ label: chart.x }];
    const bands = [];
    const tables = [];
    chart.curves.forEach((curve, k) => {
      const stroke = variable(`--c${k % kColours}`);
      const own = curve.points ? { paths: () => null, points: { show: true, size: 4 } } : { points: { show: false } };
      series.push({ label: curve.label, stroke, width: 1.5, spanGaps: true, ...own });
      tables.push([curve.x, curve.y]);
      if (!curve.low) return;
      const edge = { class: "band", stroke: "transparent", spanGaps: true, points: { show: false } };
      series.push({ label: "low", ...edge }, { label: "high", ...edge });
      bands.push({ series: [series.length - 1, series.length - 2], fill: stroke + "30" });
      tables[tables.length - 1].push(curve.low, curve.high);
    });
    return { series, bands, data: uPlot.join(tables) };
  }

  function drawSeries(chart, place, width) {
    const { series, bands, data } = seriesOptions(chart);
    const axis = { stroke: variable("--soft"), grid: { stroke: variable("--line"), width: 1 }, ticks: { stroke: variable("--line"), width: 1 } };
    const scale = chart.log ? { distr: 3 } : {};
    new uPlot({
      width, height: kSeriesHeight, series, bands,
      scales: { x: { time: false, ...scale }, y: scale },
      axes: [{ ...axis, label: chart.x }, { ...axis, label: chart.y, size: 64 }],
      cursor: { dataIdx: (plot, k, index) => (k === 0 ? index : nearestIndex(plot, k, index)) },
    }, data, place);
  }

  const base = (width) => ({
    width, style: { background: "transparent", color: "var(--text)", fontSize: "11px" }, grid: true,
  });

  function drawScatter(chart, place, width) {
    const all = [...chart.clouds, ...chart.curves];
    const labels = unique(all.map((curve) => curve.label));
    const points = chart.clouds.flatMap(pointsOf);
    place.append(swatches(labels), Plot.plot({
      ...base(width), height: 280, marginLeft: 56,
      x: { label: chart.x }, y: { label: chart.y },
      color: { domain: labels, range: labels.map((_, k) => colour(k)) },
      marks: [
        Plot.ruleY([0], { stroke: "var(--soft)" }),
        Plot.dot(points, { x: "x", y: "y", fill: "label", r: points.length < kFewPoints ? 3 : 1.6, fillOpacity: 0.55 }),
        Plot.line(chart.curves.flatMap(pointsOf), { x: "x", y: "y", z: "label", stroke: "label", strokeWidth: 2 }),
      ],
    }));
  }

  function drawBars(chart, place, width) {
    const groups = unique(chart.bars.map((bar) => bar.group));
    const labels = unique(chart.bars.map((bar) => bar.label));
    const most = Math.floor(width / 2 / 6.5);
    const margin = Math.min(width / 2, 6.5 * Math.max(...labels.map((label) => label.length)) + 16);
    const rows = labels.length * groups.length;
    if (groups.length > 1) place.append(swatches(groups));
    place.append(Plot.plot({
      ...base(width), height: 60 + (groups.length > 1 ? 12 * rows + 8 * labels.length : 20 * rows), marginLeft: margin,
      x: { label: chart.x }, y: { domain: groups, axis: null },
      fy: { domain: labels, label: null, axis: "left", tickFormat: (text) => shortened(text, most), padding: 0.15 },
      color: { domain: groups, range: groups.map((_, k) => colour(k)) },
      marks: [
        Plot.barX(chart.bars.filter((bar) => bar.value !== null), { fy: "label", y: "group", x: "value", fill: "group", fillOpacity: 0.75 }),
        Plot.ruleY(chart.bars.filter((bar) => bar.low !== null), { fy: "label", y: "group", x1: "low", x2: "high", strokeWidth: 2.5 }),
        Plot.ruleX([0], { stroke: "var(--soft)" }),
      ],
    }));
  }

  // Returns the labels near the beginnings of the strips' lines, and in the middle of areas without a line.
  function namesOnMap(chart) {
    const middle = (curve) => ({ x: d3.mean(curve.x), y: d3.mean(curve.y), label: curve.label });
    const lined = new Set(chart.lines.map((curve) => curve.label));
    return [...chart.lines.map((curve) => pointsOf(curve)[Math.floor(curve.x.length / 12)]), ...chart.areas.filter((area) => !lined.has(area.label)).map(middle)];
  }

  function valuedMarks(valued) {
    const dots = valued.x.map((x, k) => ({ x, y: valued.y[k], value: valued.value[k] }));
    return [Plot.dot(dots, { x: "x", y: "y", fill: "value", r: dots.length < kFewPoints ? 3.5 : 2 })];
  }

  function drawMap(chart, place, width) {
    const labels = unique([...chart.areas, ...chart.lines, ...chart.points].map((curve) => curve.label));
    const paint = (curve) => (chart.valued ? "var(--soft)" : colour(labels.indexOf(curve.label)));
    const curves = [...chart.areas, ...chart.lines, ...chart.points, ...(chart.valued ? [chart.valued] : [])];
    const extent = (key) => d3.extent(curves.flatMap((curve) => curve[key]));
    const [west, east] = extent("x");
    const [south, north] = extent("y");
    const high = Math.max(north - south, 1) / Math.max(east - west, 1);
    if (!chart.valued) place.append(swatches(labels));
    const xy = { x: "x", y: "y" };
    place.append(Plot.plot({
      ...base(Math.max(240, Math.min(width, kTallestMap / high))), aspectRatio: 1, marginLeft: 60, inset: 8,
      x: { label: "east [m]" }, y: { label: "north [m]" },
      ...(chart.valued ? { color: { type: "log", domain: [chart.valued.low, chart.valued.high], clamp: true, scheme: "Turbo", legend: true, ticks: 4, tickFormat: "~g", label: chart.valued.label } } : {}),
      marks: [
        ...chart.areas.map((area) => Plot.line(pointsOf(area), { ...xy, curve: "linear-closed", fill: paint(area), fillOpacity: 0.1, stroke: paint(area), strokeWidth: 0.7 })),
        ...chart.lines.map((line) => Plot.line(pointsOf(line), { ...xy, stroke: paint(line), strokeWidth: 1.5 })),
        ...chart.points.map((cloud) => Plot.dot(pointsOf(cloud), { ...xy, fill: paint(cloud), r: 1.8, fillOpacity: 0.6 })),
        ...(chart.valued ? valuedMarks(chart.valued) : []),
        ...(chart.areas.length ? [Plot.text(namesOnMap(chart), { ...xy, text: "label", fill: "var(--text)", stroke: "var(--surface)", strokeWidth: 4 })] : []),
      ],
    }));
  }

  function drawHeat(chart, place, width) {
    const cells = chart.rows.flatMap((row, r) => chart.columns.map((column, c) => ({ row, column, value: chart.values[r][c] })));
    const margin = 7 * Math.max(...chart.rows.map((row) => row.length)) + 14;
    const options = { x: "column", y: "row" };
    place.append(Plot.plot({
      ...base(Math.min(width, margin + 74 * chart.columns.length)), grid: false, height: 50 + 34 * chart.rows.length, marginLeft: margin,
      x: { domain: chart.columns, label: null, axis: "top" }, y: { domain: chart.rows, label: null },
      color: { scheme: "RdBu", domain: [-1, 1] },
      marks: [
        Plot.cell(cells, { ...options, fill: "value" }),
        Plot.text(cells, { ...options, text: (cell) => (cell.value === null ? "" : (100 * cell.value).toFixed(0)),
          fill: (cell) => (Math.abs(cell.value) > 0.6 ? "white" : "black") }),
      ],
    }));
  }

  const draw = { series: drawSeries, scatter: drawScatter, bars: drawBars, map: drawMap, heat: drawHeat };
  const drawnWidth = new Map();

  function drawFigure(figure) {
    const place = figure.querySelector("div");
    const width = Math.floor(place.clientWidth);
    if (width < 50 || drawnWidth.get(figure) === width) return;
    drawnWidth.set(figure, width);
    const chart = charts[figure.dataset.chart];
    place.replaceChildren();
    place.style.minHeight = "0";
    draw[chart.type](chart, place, width);
  }

  const figures = [...document.querySelectorAll("figure[data-chart]")];
  const redraw = () => figures.filter((figure) => drawnWidth.delete(figure)).forEach(drawFigure);
  const seen = new IntersectionObserver(
    (entries) => entries.filter((entry) => entry.isIntersecting).forEach((entry) => drawFigure(entry.target)),
    { rootMargin: "300px" });
  figures.filter((figure) => figure.getBoundingClientRect().top < innerHeight).forEach(drawFigure);
  figures.forEach((figure) => seen.observe(figure));
  new ResizeObserver(() => [...drawnWidth.keys()].forEach(drawFigure)).observe(document.body);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", () => {
    document.documentElement.classList.add("printing");
    const today = new Date().toISOString().slice(0, 10);
    document.querySelectorAll(".today").forEach((date) => { date.textContent = today; });
    document.querySelectorAll("details").forEach((details) => { details.open = true; });
    redraw();
    figures.forEach(drawFigure);
  });
  addEventListener("afterprint", () => {
    document.documentElement.classList.remove("printing");
    redraw();
  });
})();
