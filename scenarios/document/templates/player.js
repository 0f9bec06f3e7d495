"use strict";
// Frame player: draws the frames of the page's data on a canvas; no library, no network.
(async () => {
  const root = document.getElementById("player"), canvas = root.querySelector("canvas");
  const bytes = Uint8Array.from(atob(document.getElementById("player-data").textContent), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const data = JSON.parse(await new Response(stream).text());
  const frames = data.frames, colors = root.dataset.colors.split(" "), many = colors.length > 1;
  const parts = root.querySelectorAll("[data-part]"), slider = root.querySelector("input[type=range]");
  const view = { x: 0, y: 0, reach: 40 };  // middle in drawing coordinates (right, up), half height [m]
  let at = Math.max(0, frames.findIndex(frame => frame.n === data.start)), timer = 0;
  if (!frames.length) return;  // the section stays hidden
  slider.max = frames.length - 1;

  const tone = name => getComputedStyle(root).getPropertyValue("--" + name);
  const shown = part => [...parts].every(box => box.dataset.part !== part || box.checked);
  const scale = () => canvas.clientHeight / (2 * view.reach);
  const px = (x, y) => [canvas.clientWidth / 2 + (-y - view.x) * scale(), canvas.clientHeight / 2 - (x - view.y) * scale()];

  function outline(ink, [x, y, yaw, length, width], color, line, dash) {
    const c = Math.cos(yaw / 1000), s = Math.sin(yaw / 1000);
    const corner = (a, b) => px((x + a * length * c / 2 - b * width * s / 2) / 100, (y + a * length * s / 2 + b * width * c / 2) / 100);
    ink.beginPath();
    for (const [a, b] of [[1, 1], [-1, 1], [-1, -1], [1, -1]]) ink.lineTo(...corner(a, b));
    ink.closePath();
    Object.assign(ink, { strokeStyle: tone(color), lineWidth: line });
    ink.setLineDash(dash);
    ink.stroke();
    return px((x + c * (length / 2 + 200)) / 100, (y + s * (length / 2 + 200)) / 100);
  }
  function write(ink, text, [x, y], color, bold) {
    ink.font = (bold ? "bold " : "") + "12px system-ui, sans-serif";
    Object.assign(ink, { textAlign: "center", textBaseline: "middle", lineWidth: 3, strokeStyle: tone("page"), fillStyle: tone(color) });
    ink.setLineDash([]);
    ink.strokeText(text, x, y);
    ink.fillText(text, x, y);
  }
  function dots(ink, differences, color, size) {
    ink.fillStyle = tone(color);
    for (let k = 0, x = 0, y = 0; k < differences.length; k += 2) {
      x += differences[k], y += differences[k + 1];
      const [left, top] = px(x / 10, y / 10);
      ink.fillRect(left - size / 2, top - size / 2, size, size);
    }
  }
  function tracks(ink, frame) {
    frame.tracks.forEach((rows, tracker) => rows.forEach(([x, y, yaw, length, width, id, solid, wrong]) => {
      if (!shown("tracker-" + tracker)) return;
      const color = wrong && !many ? "bad" : colors[tracker];
      const ahead = outline(ink, [x, y, yaw, length, width], color, solid ? 2.6 + 1.6 * (colors.length - 1 - tracker) : 1.4, solid ? [] : [5, 4]);
      if (!solid) return;
      ink.lineWidth = 2.6;
      ink.beginPath();
      ink.moveTo(...px((x + Math.cos(yaw / 1000) * length / 2) / 100, (y + Math.sin(yaw / 1000) * length / 2) / 100));
      ink.lineTo(...ahead);
      ink.stroke();
      write(ink, "t" + id + (wrong ? " false" : ""), ahead, color, true);
    }));
  }
  function draw() {
    const frame = frames[at], ratio = devicePixelRatio || 1, ink = canvas.getContext("2d");
    canvas.width = canvas.clientWidth * ratio, canvas.height = canvas.clientHeight * ratio;
    ink.scale(ratio, ratio);
    const size = Math.max(1.5, Math.min(4, 0.12 * scale()));
    if (shown("points")) ["faint", "sky", "red"].forEach((color, k) => dots(ink, frame.points[k] || [], color, size + (k ? 0.7 : 0)));
    const truth = shown("truth") ? frame.truth : [];
    truth.forEach(([x, y, yaw, length, width, , graded]) => {
      outline(ink, [x, y, yaw, length, width], graded ? "ink" : "muted", 1.2, graded ? [] : [3, 3]);
      const cos = Math.cos(yaw / 1000), sin = Math.sin(yaw / 1000);
      ink.beginPath();
      for (const [along, across] of [[length / 2, width / 2], [length / 2 - width / 4, 0], [length / 2, -width / 2]])
        ink.lineTo(...px((x + along * cos - across * sin) / 100, (y + along * sin + across * cos) / 100));
      ink.stroke();
    });
    if (shown("fits")) frame.fits.forEach((rows, k) => shown("tracker-" + k) && rows.forEach(box => outline(ink, box, many ? colors[k] : "orange", 1.5, many ? [1, 2] : [])));
    tracks(ink, frame);
    truth.forEach(([x, y, , , , name, graded]) => graded && name >= 0 && write(ink, data.names[name], px(x / 100, y / 100), "ink", false));
    const [length, width] = data.ego, [left, top] = px(length / 200, width / 200);
    ink.fillStyle = tone("ink");
    ink.fillRect(left, top, width / 100 * scale(), length / 100 * scale());
    ink.fillRect(12, canvas.clientHeight - 14, 10 * scale(), 3);
    write(ink, "10 m", [12 + 5 * scale(), canvas.clientHeight - 24], "ink", false);
    slider.value = at;
    const time = frame.t === null ? "" : ", " + frame.t.toFixed(2) + " s", none = frame.points.length ? "" : "; the points of this frame are not in the page";
    root.querySelector("output").textContent = "Frame " + frame.n + " of " + frames[frames.length - 1].n + time + none;
    slider.setAttribute("aria-valuetext", "frame " + frame.n + time);
  }
  function show(index) { at = Math.max(0, Math.min(frames.length - 1, index)); draw(); }
  function zoom(factor, x, y) {
    const before = scale(), across = (x ?? canvas.clientWidth / 2) - canvas.clientWidth / 2, down = (y ?? canvas.clientHeight / 2) - canvas.clientHeight / 2;
    view.reach = Math.max(3, Math.min(80, view.reach / factor));
    view.x += across / before - across / scale(), view.y -= down / before - down / scale();
    draw();
  }
  function play() {
    const button = root.querySelector("[data-do=play]");
    if (timer) timer = clearInterval(timer) || 0;
    else timer = setInterval(() => at + 1 < frames.length ? show(at + 1) : play(), 80);
    button.textContent = timer ? "Pause" : "Play";
  }
  const actions = {
    back: () => show(at - 1), on: () => show(at + 1), play, first: () => show(0), last: () => show(frames.length - 1),
    near: () => zoom(1.25), far: () => zoom(0.8), all: () => { Object.assign(view, { x: 0, y: 0, reach: 40 }); draw(); },
  };
  const keys = { ArrowLeft: "back", ArrowRight: "on", " ": "play", Home: "first", End: "last", "+": "near", "=": "near", "-": "far", "0": "all" };
  root.querySelectorAll("[data-do]").forEach(button => button.addEventListener("click", actions[button.dataset.do]));
  parts.forEach(box => box.addEventListener("change", draw));
  slider.addEventListener("input", () => show(+slider.value));
  canvas.addEventListener("keydown", event => {
    if (!(event.key in keys) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[keys[event.key]]();
  });
  canvas.addEventListener("wheel", event => {
    if (document.activeElement !== canvas && !event.ctrlKey) return;  // the page scrolls
    event.preventDefault();
    zoom(Math.exp(-0.002 * event.deltaY), event.offsetX, event.offsetY);
  }, { passive: false });
  canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); canvas.focus(); });
  canvas.addEventListener("pointermove", event => {
    if (!event.buttons) return;
    view.x -= event.movementX / scale(), view.y += event.movementY / scale();
    draw();
  });
  document.addEventListener("click", event => {
    const link = event.target.closest("[data-frame]");
    if (link) show(frames.findIndex(frame => frame.n === +link.dataset.frame));
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  root.hidden = false;
  new ResizeObserver(draw).observe(canvas);
})();
