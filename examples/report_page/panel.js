// The panel, the steps and the keys.

function showShape() {
  picture.move(state.step, state.amount * state.scale);
  const inverted = picture.arrays["inside" + state.step].length > 0;
  picture.inside.visible = inverted && element("show_inverted").checked;
  element("scale").value = plainNumber(state.scale);
  const factor = state.amount * state.scale;
  element("drawn_scale").textContent = factor === 1 ? "" : factor === 0 ? "drawn at rest"
    : `displacements × ${shortNumber(factor)}`;
  eye.draw();
}

function showStep() {
  const {t, inverted} = manifest.steps[state.step];
  element("step").value = state.step;
  element("step_name").textContent = `t = ${shortNumber(t)}  (${state.step + 1} of ${manifest.steps.length})`;
  element("step").setAttribute("aria-valuetext", `t = ${t}`);
  element("inverted_label").hidden = !manifest.steps.some(step => step.inverted);
  element("inverted_count").textContent = `inverted elements: ${inverted}`;
  if (element("over").value === "one") state.low = null;
  showShape();
  showColours();
}

function chooseField(name) {
  state.field = manifest.fields.find(field => field.name === name);
  element("field").value = name;
  const columns = Object.keys(state.field.columns);
  state.column = columns[0];
  element("column").innerHTML = columns.map(each => `<option>${each}</option>`).join("");
  element("column_label").hidden = columns.length < 2;
  state.low = null;
  showColours();
}

/** How many times a displacement must be drawn to be a tenth of the body's size, in round numbers. */
function visibleScale() {
  const size = 2 * picture.rest.reduce((most, each) => Math.max(most, Math.abs(each)), 0);
  let largestMove = 0;
  manifest.steps.forEach((_, step) => picture.arrays["u" + step].forEach(each => {
    largestMove = Math.max(largestMove, Math.abs(each));
  }));
  if (!largestMove) return 1;
  const wanted = 0.1 * size / largestMove, power = 10 ** Math.floor(Math.log10(wanted));
  return wanted < 4 ? 1 : power * [5, 2, 1].find(each => each * power <= wanted);
}

function showRest(shown) {
  picture.outline.visible = picture.ghost.visible = element("show_rest").checked = shown;
}

function setScale(value) {
  if (Number.isFinite(value)) state.scale = value;
  showShape();
}

function showReading(event) {
  const found = event && eye.hit(event.clientX, event.clientY);
  if (!found) { element("reading").textContent = ""; return; }
  const {triangle, vertex} = found, {arrays} = picture, {field} = state;
  const row = field.onVertices ? vertex : arrays.triangle_cells[triangle];
  const named = field.onVertices ? `vertex ${arrays.vertices[vertex]}` : `cell ${arrays.cells[row]}`;
  const at = manifest.center.map((middle, axis) =>
    shortNumber(+(arrays.rest[3 * vertex + axis] + middle).toPrecision(4)));
  element("reading").textContent = `${field.title}${state.column ? ", " + state.column : ""}: ` +
    `${shortNumber(values(state.step)[row])}${field.unit ? " " + field.unit : ""}\n` +
    `${named}, at rest near (${at.slice(0, manifest.flat ? 2 : 3).join(", ")})`;
}

function changeStep(by) {
  const count = manifest.steps.length;
  state.step = (state.step + by + count) % count;
  showStep();
}

let player = 0;
function play() {
  if (manifest.steps.length < 2) return;
  if (player) { clearInterval(player); player = 0; }
  else player = setInterval(() => changeStep(1), Math.max(40, Math.min(400, 6000 / manifest.steps.length)));
  element("play").textContent = player ? "❚❚" : "▶";
  element("play").setAttribute("aria-label", player ? "Pause" : "Play");
}

function toggle(id) {
  element(id).checked = !element(id).checked;
  element(id).dispatchEvent(new Event("change"));
}

const KEYS = {
  ArrowLeft: () => eye.turn(-0.1, 0), ArrowRight: () => eye.turn(0.1, 0),
  ArrowUp: () => eye.turn(0, -0.1), ArrowDown: () => eye.turn(0, 0.1),
  "+": () => eye.zoom(0.9), "=": () => eye.zoom(0.9), "-": () => eye.zoom(1 / 0.9),
  0: () => eye.look("start"), x: () => eye.look("x"), y: () => eye.look("y"), z: () => eye.look("z"),
  e: () => toggle("show_edges"), "[": () => changeStep(-1), "]": () => changeStep(1), " ": play};

function savePicture() {
  eye.drawNow();
  const link = document.createElement("a");
  link.href = eye.canvas.toDataURL("image/png");
  link.download = document.title.replace(/[^\w.-]+/g, "_") + ".png";
  link.click();
}

function listen() {
  const on = (id, event, act) => element(id).addEventListener(event, act);
  on("field", "change", event => chooseField(event.target.value));
  on("column", "change", event => { state.column = event.target.value; state.low = null; showColours(); });
  on("map", "change", showColours);
  on("bands", "change", showColours);
  on("over", "change", () => { state.low = null; showColours(); });
  for (const end of ["low", "high"])
    on(end, "change", event => {
      const value = event.target.value.trim();
      if (value === "") state.low = null;  // an empty end: as it was
      else if (Number.isFinite(+value)) state[end] = +value;
      showColours();
    });
  on("amount", "input", event => { state.amount = +event.target.value; showShape(); });
  on("scale", "change", event => setScale(+event.target.value));
  on("true_scale", "click", () => setScale(1));
  on("auto_scale", "click", () => setScale(visibleScale()));
  on("show_edges", "change", event => { picture.edges.visible = event.target.checked; eye.draw(); });
  on("show_rest", "change", event => { showRest(event.target.checked); eye.draw(); });
  on("show_obstacles", "change", event => {
    if (picture.obstacles) picture.obstacles.visible = event.target.checked;
    eye.draw();
  });
  on("show_inverted", "change", event => {
    picture.uniforms.marks.value = +event.target.checked;
    showShape();
  });
  on("views", "click", event => event.target.dataset.view && eye.look(event.target.dataset.view));
  on("save", "click", savePicture);
  on("step", "input", event => { state.step = +event.target.value; showStep(); });
  on("play", "click", play);
  on("canvas", "keydown", event => {
    const act = !event.ctrlKey && !event.metaKey && !event.altKey && KEYS[event.key];
    if (act) { act(); event.preventDefault(); }
  });
  let pending = null;
  on("canvas", "pointermove", event => {
    if (event.buttons || pending) return;
    pending = setTimeout(() => { pending = null; showReading(event); }, 60);
  });
  on("canvas", "pointerleave", () => { clearTimeout(pending); pending = null; showReading(null); });
}

function listRegions() {
  element("regions").innerHTML = manifest.regions.map(each =>
    `<label class="check"><input type="checkbox" checked value="${each}">
      region ${escaped(labelName("region", each))}</label>`).join("");
  element("regions").addEventListener("change", () => {
    const boxes = [...element("regions").querySelectorAll("input:checked")];
    picture.showRegions(new Set(boxes.map(box => +box.value)));
    eye.draw();
  });
}

function listChoices() {
  element("field").innerHTML = manifest.fields.map(field =>
    `<option value="${field.name}">${field.title}</option>`).join("");
  element("map").innerHTML = Object.keys(manifest.maps).map(each => `<option>${each}</option>`).join("");
  const several = manifest.steps.length > 1;
  element("obstacles_label").hidden = !manifest.obstacles;
  element("timeline").hidden = element("over_label").hidden = !several;
  element("step").max = manifest.steps.length - 1;
  listRegions();
}

/** Light or dark: as the system says, until the button is pressed. */
function chooseTheme() {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const set = theme => { root.dataset.theme = theme; };
  set(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => set(dark.matches ? "dark" : "light"));
  element("theme").addEventListener("click", () => set(root.dataset.theme === "dark" ? "light" : "dark"));
}

async function start() {
  chooseTheme();
  const arrays = await unpack();
  picture = new BodyPicture(arrays);
  try {
    eye = new Eye(element("canvas"), picture);
  } catch (problem) {
    fail("this browser offers no WebGL");
    return;
  }
  listChoices();
  state.step = manifest.steps.length - 1;
  picture.edges.visible = element("show_edges").checked = picture.count < 12000;
  showRest(true);
  state.scale = visibleScale();
  if (state.scale < 4 || manifest.flat) state.scale = 1;
  listen();
  chooseField(manifest.fields[0].name);
  showStep();
  eye.look("start");
  eye.drawNow();
  root.dataset.viewer = "ready";
}

start();
