(() => {
  const make = (name, parent, text) => {
    const made = document.createElement(name);
    if (text) made.textContent = text;
    parent.append(made);
    return made;
  };
  const number = value => String(Number(value.toPrecision(4))).replace("-", "\u2212");
  const said = (label, value) => {
    const [, name, unit] = label.match(/^(.*?)(?: \(([^()]*)\))?$/);
    return `${name} ${number(value)}${unit ? "\u00a0" + unit : ""}`;
  };
  const at = (axis, share) => {
    const [low, high] = axis.lim;
    return axis.log ? low * (high / low) ** share : low + (high - low) * share;
  };
  const share = (axis, value) => {
    const [low, high] = axis.lim;
    return axis.log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  };
  const place = (panel, [x, y]) => [
    panel.box[0] + panel.box[2] * share(panel.x, x),
    panel.box[1] + panel.box[3] * (1 - share(panel.y, y)),
  ];
  const nearest = (line, panel, x, y) => {
    const along = line.points.every((point, k) => !k || point[0] >= line.points[k - 1][0]);
    let best = null, least = along ? 12 : 8;
    for (const point of line.points) {
      const [px, py] = place(panel, point);
      const distance = along ? Math.abs(px - x) : Math.hypot(px - x, py - y);
      if (distance < least) [best, least] = [point, distance];
    }
    return best;
  };
  for (const figure of document.querySelectorAll("figure[data-plot]")) {
    const svg = figure.querySelector("svg"), plot = JSON.parse(figure.dataset.plot);
    const tip = make("div", figure), cross = document.createElementNS("http://www.w3.org/2000/svg", "path");
    tip.className = "tip";
    tip.hidden = true;
    cross.setAttribute("class", "cross");
    svg.append(cross);
    const hide = () => { tip.hidden = true; cross.setAttribute("d", ""); };
    svg.addEventListener("pointerleave", hide);
    svg.addEventListener("pointermove", event => {
      const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      const panel = plot.axes.find(({ box: [left, top, wide, high] }) => x >= left && x <= left + wide && y >= top && y <= top + high);
      if (!panel) return hide();
      const [left, top, wide, high] = panel.box;
      const x0 = at(panel.x, (x - left) / wide), y0 = at(panel.y, 1 - (y - top) / high);
      const bar = panel.bars.find(({ ends: [a, b, c, d] }) => x0 >= a && x0 <= b && y0 >= c && y0 <= d);
      const words = bar ? [bar.text] : [];
      let datum = null;
      for (const line of bar ? [] : panel.lines) {
        if (off.has(line.name)) continue;
        const point = nearest(line, panel, x, y);
        if (!point) continue;
        if (!datum || point[0] !== datum[0]) words.push(said(panel.x.label, point[0]));
        words.push(`${line.name ? line.name + ": " : ""}${said(panel.y.label, point[1])}`);
        datum = datum || point;
      }
      if (panel.earth) {
        const [east, north] = datum || [x0, y0];
        words.push(panel.earth.map(([zero, dx, dy]) => (zero + dx * east + dy * north).toFixed(5) + "\u00b0").join(" "));
      }
      if (!words.length) return hide();
      tip.textContent = words.slice(0, 8).join("\n");
      tip.hidden = false;
      const frame = figure.getBoundingClientRect();
      tip.style.left = `${Math.min(event.clientX - frame.left + 14, frame.width - tip.offsetWidth)}px`;
      tip.style.top = `${event.clientY - frame.top + 14}px`;
      const [u, v] = bar || !datum ? [x, y] : place(panel, datum);
      const [a, b, c, d] = bar ? bar.ends : [];
      const [p, q] = bar ? place(panel, [a, d]) : [], [r, s] = bar ? place(panel, [b, c]) : [];
      cross.setAttribute("d", bar ? `M${p},${q}H${r}V${s}H${p}Z` : datum || panel.earth ? `M${u},${top}v${high}M${left},${v}h${wide}` : "");
    });
    const off = new Set();
    if (plot.series) {
      const row = make("div", figure);
      row.className = "switches";
      for (const { name, ids } of plot.series) {
        const button = make("button", row, name);
        button.type = "button";
        button.setAttribute("aria-pressed", "true");
        button.addEventListener("click", () => {
          const on = off.delete(name);
          if (!on) off.add(name);
          button.setAttribute("aria-pressed", String(on));
          for (const id of ids) {
            const drawn = document.getElementById(`${figure.dataset.name}-${id}`);
            if (drawn) drawn.style.display = on ? "" : "none";
          }
        });
      }
    }
    if (plot.slider) {
      const row = make("label", figure), { label, x, text, start } = plot.slider, panel = plot.axes[0];
      row.className = "slider";
      make("span", row, label);
      const input = make("input", row), told = make("output", row), mark = cross.cloneNode();
      mark.setAttribute("class", "mark");
      svg.append(mark);
      Object.assign(input, { type: "range", min: 0, max: x.length - 1, step: 1, value: start });
      const move = () => {
        told.textContent = text[input.value];
        input.setAttribute("aria-valuetext", text[input.value]);
        mark.setAttribute("d", `M${panel.box[0] + panel.box[2] * share(panel.x, x[input.value])},${panel.box[1]}v${panel.box[3]}`);
      };
      input.addEventListener("input", move);
      move();
    }
  }
  addEventListener("beforeprint", () => document.querySelectorAll("details.folded").forEach(each => { each.open = true; }));
})();
