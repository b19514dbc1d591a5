// Browser side of the explorer: address, live updates one at a time, undo, copying, saving, colors.
(function () {
  "use strict";
  const PAUSE = 350; // [ms] without a move after which the page requests bands, tables and texts
  const MOST = 5e6; // [bytes] largest file that the server reads
  const LOST = 8000; // [ms] timeout of a request
  let base = null, busy = 0, wanted = null, serial = 0, timer = null, online = true;

  const props = (id, values) => window.dash_clientside.set_props(id, values);

  const tab = Math.random().toString(36).slice(2); // identifies the tab: the server answers only its newest request

  // One request at a time: the newest settings are requested when the last answer is drawn.
  function ask() {
    if (wanted === null || busy) return;
    const mine = (busy = ++serial), values = wanted;
    wanted = null;
    const body = JSON.stringify({ tab, serial: mine, view: base.view, search: search(values), values });
    const lost = AbortSignal.timeout(LOST);
    fetch("/_live", { method: "POST", headers: { "Content-Type": "application/json" }, body, signal: lost })
      .then((answer) => answer.json())
      .then((found) => (mine === busy ? draw(found.figures || {}) : null))
      .then(() => reached(true), () => reached(false))
      .then(() => requestAnimationFrame(() => setTimeout(() => free(mine), 0)));
  }

  function reached(now) {
    const text = "The server does not answer, so the figures and numbers show earlier settings. Run propmap explore again.";
    if (now !== online) props("trouble", { children: now ? "" : text });
    online = now;
  }

  function draw(figures) {
    for (const [name, figure] of Object.entries(figures)) {
      const place = document.getElementById(JSON.stringify({ graph: name }));
      const graph = place && place.querySelector(".js-plotly-plot");
      if (!graph || !graph.offsetParent) continue;
      // Figures outside the window are drawn later, when the controls have stopped moving.
      const box = graph.getBoundingClientRect();
      if (box.bottom < 0 || box.top > window.innerHeight) continue;
      // The figure is drawn when this call returns; its promise can wait longer, for fonts.
      window.Plotly.react(graph, figure.data, { ...figure.layout, autosize: true });
    }
  }

  function free(mine) {
    if (mine !== busy) return;
    busy = 0;
    window.propmap.drawn = mine;
    window.dispatchEvent(new Event("propmap-drawn"));
    if (wanted !== null) ask();
    else if (last && base && !base.empty) later(last);
  }

  function later(values) {
    clearTimeout(timer);
    asked = -1;
    timer = setTimeout(() => {
      asked = ++serial;
      props("settled", { data: { tab, serial: asked, values } });
    }, PAUSE);
  }

  function search(values) {
    const query = new URLSearchParams(base ? base.query : {});
    for (const [name, value] of Object.entries(values)) {
      if (value !== null && value !== undefined) query.set(name, Array.isArray(value) ? value.join(",") : value);
    }
    return "?" + query.toString();
  }

  const links = (menu) => menu.map((id) => "/" + id.menu + window.location.search);
  const numbered = (name) => document.getElementById(JSON.stringify({ number: name })) !== null;
  const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
  let last = null, shown = null;
  const past = []; // settings before each move, for undo

  let asked = 0, answered = 0; // serials of the last settled request and of the last answer

  window.propmap = {
    // Whether the page shows the answers to all requests.
    quiet: () => !busy && wanted === null && asked > 0 && asked === answered,
    drawn: 0,
    undo() {
      if (past.length > 1) past.pop();
      return past.length ? past[past.length - 1] : null;
    },
  };

  window.dash_clientside = Object.assign({}, window.dash_clientside, {
    propmap: {
      // Runs when a control was moved or another page was loaded.
      moved(values, newBase, ids, menu) {
        const no = window.dash_clientside.no_update;
        if (!newBase) return [no, menu.map(() => no)];
        if (newBase.empty) clearTimeout(timer);
        const fresh = newBase !== base;
        base = newBase;
        const now = {};
        ids.forEach((id, k) => (now[id.control] = values[k]));
        // A slider and its number field have the same value.
        for (const [name, value] of Object.entries(now)) {
          if (last && !fresh && !same(last[name], value) && numbered(name)) props({ number: name }, { value: Number(value) });
        }
        const address = search(now);
        if (ids.length) window.history.replaceState(window.history.state, "", window.location.pathname + address);
        const hrefs = links(menu);
        document.querySelectorAll(".menu-item").forEach((item, k) => {
          if (menu[k].menu === base.view) item.setAttribute("aria-current", "page");
          else item.removeAttribute("aria-current");
        });
        if (fresh) { past.length = 0; busy = 0; wanted = null; }
        else if (!same(now, last)) { wanted = now; setTimeout(ask, 0); }
        if (!same(now, past[past.length - 1])) past.push(now);
        if (past.length > 200) past.shift();
        last = now;
        if (newBase.empty) { busy = 0; wanted = null; asked = answered = ++serial; }
        // The settled request waits until all moves are drawn; see free().
        else if (wanted === null && !busy) later(now);
        else { clearTimeout(timer); asked = -1; }
        return [address, fresh ? hrefs : menu.map(() => no)];
      },
      // Runs when a number was typed next to a slider.
      typed(numbers, ids) {
        const by = window.dash_clientside.callback_context.triggered_id;
        const k = by ? ids.findIndex((id) => id.number === by.number) : -1;
        const value = k < 0 ? null : numbers[k];
        if (value !== null && value !== undefined && last && Number(last[by.number]) !== value)
          props({ control: by.number }, { value });
        return window.dash_clientside.no_update;
      },
      // Runs when a point of a figure was dragged; sets the control of this point.
      dragged(moves, drawn, ids) {
        const no = window.dash_clientside.no_update;
        const by = window.dash_clientside.callback_context.triggered_id;
        const k = by ? ids.findIndex((id) => id.graph === by.graph) : -1;
        const meta = k < 0 ? null : ((drawn[k] || {}).layout || {}).meta;
        if (!meta || !meta.drag || !moves[k]) return no;
        const found = {};
        for (const [key, value] of Object.entries(moves[k])) {
          const at = /^shapes\[(\d+)\]\.(y[01])$/.exec(key);
          if (at) (found[at[1]] = found[at[1]] || {})[at[2]] = value;
        }
        for (const [place, ends] of Object.entries(found)) {
          if (ends.y0 === undefined || ends.y1 === undefined) continue;
          const y = 0.5 * (ends.y0 + ends.y1), own = meta.base[place];
          const moved = meta.share ? (100 * y) / own : y - own;
          const value = Math.round(moved / meta.step) * meta.step;
          props({ control: meta.drag[place] }, { value: Number(value.toFixed(3)) });
        }
        return no;
      },
      undo(clicks) {
        const no = window.dash_clientside.no_update;
        if (!clicks) return no;
        const before = window.propmap.undo();
        if (!before) return no;
        for (const [name, value] of Object.entries(before))
          if (!same(value, last[name])) props({ control: name }, { value });
        return no;
      },
      // Runs when a file is opened or dropped. Larger files are refused here, because the server refuses them too.
      dropped(content, name) {
        const no = window.dash_clientside.no_update;
        if (!content) return [no, no];
        const size = 0.75 * (content.length - content.indexOf(","));
        if (size > MOST) return [no, `${name}: the file has ${(1e-6 * size).toFixed(1)} MB, expected at most 5 MB; give a smaller file`];
        return [{ name, content }, `reading ${name} …`];
      },
      ticking(job) {
        return !job;
      },
      settled(number, menu) {
        answered = number;
        return [window.dash_clientside.no_update, links(menu)];
      },
      theme(clicks) {
        const root = document.documentElement;
        const dark = root.dataset.theme ? root.dataset.theme === "dark"
          : window.matchMedia("(prefers-color-scheme: dark)").matches;
        root.dataset.theme = dark ? "light" : "dark";
        try { localStorage.setItem("propmap-theme", root.dataset.theme); } catch (e) { /* no storage in private windows */ }
        return root.dataset.theme;
      },
      copied(clicks, command, python) {
        const by = window.dash_clientside.callback_context.triggered_id;
        if (!by || !clicks.some(Boolean)) return "";
        const text = by.copy === "command" ? command : python;
        const done = () => by.copy + " copied";
        if (navigator.clipboard) return navigator.clipboard.writeText(text).then(done, () => fallback(text, done));
        return fallback(text, done);
      },
      picture(clicks) {
        const no = window.dash_clientside.no_update;
        const by = window.dash_clientside.callback_context.triggered_id;
        if (!by || !clicks.some(Boolean)) return no;
        const id = JSON.stringify({ graph: by.picture });
        const graph = document.getElementById(id).querySelector(".js-plotly-plot");
        const size = graph.getBoundingClientRect();
        const scale = by.as === "png" ? 2 : 1;
        window.Plotly.downloadImage(graph, {
          format: by.as, filename: "propmap-" + by.picture, width: size.width, height: size.height, scale,
        });
        return no;
      },
    },
  });

  // Browsers provide no clipboard to pages of other machines without TLS.
  function fallback(text, done) {
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    const worked = document.execCommand("copy");
    area.remove();
    return worked ? done() : "select the text below and copy it";
  }

  // Correct the accessibility of Dash: it marks labels of inputs as options, and file inputs have no name.
  function named(root) {
    for (const option of root.querySelectorAll('.dash-options-list-option[role="option"]')) {
      option.removeAttribute("role");
      option.removeAttribute("aria-selected");
    }
    for (const list of root.querySelectorAll('[role="listbox"].options, .options [role="listbox"]')) {
      list.setAttribute("role", "group");
      list.removeAttribute("aria-multiselectable");
    }
    for (const input of root.querySelectorAll('input[type="file"]:not([aria-label])'))
      input.setAttribute("aria-label", "a file to open");
  }
  new MutationObserver(() => named(document)).observe(document, { childList: true, subtree: true });

  try {
    const kept = localStorage.getItem("propmap-theme");
    if (kept) document.documentElement.dataset.theme = kept;
  } catch (e) { /* no storage in private windows */ }
})();
