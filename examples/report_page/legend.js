// What is shown, in which colours, and the scale that says so.

const element = id => document.getElementById(id);
// For labels; after Okabe and Ito, told apart by most eyes.
const LABEL_COLOURS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442",
                       "#7a7a7a", "#5b3fa0", "#8c510a", "#1b4d3e", "#e7298a"];

const state = {field: null, column: "", step: 0, amount: 1, scale: 1, low: null, high: null};
let picture, eye;

function shortNumber(value) {
  const size = Math.abs(value);
  if (size === 0 || (size >= 1e-3 && size < 1e5)) return String(+value.toPrecision(5)).replace("-", "−");
  const [mantissa, exponent] = value.toExponential(3).split("e");
  const power = String(+exponent).replace(/[-0-9]/g, digit => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)]);
  return (+mantissa + "·10" + power).replace("-", "−");
}

function plainNumber(value) {
  return String(+value.toPrecision(6));
}

function escaped(text) {
  return text.replace(/[&<"]/g, letter => `&#${letter.charCodeAt(0)};`);
}

/** Least and largest value of the chosen column, over all steps or in this one. */
function naturalRange() {
  const spans = state.field.columns[state.column];
  const used = element("over").value === "one" ? [spans[state.step]] : spans;
  let low = Math.min(...used.map(span => span[2])), high = Math.max(...used.map(span => span[3]));
  if (state.column === "magnitude") [low, high] = [0, high || 1];
  const least = 1e-5 * Math.max(Math.abs(low), Math.abs(high)) || 1;
  if (high - low < least) [low, high] = [low - least / 2, high + least / 2];
  return [low, high];
}

/** The labels in a field of labels, over all steps; null for fields of quantities. */
function labels() {
  if (!state.field.labels) return null;
  const seen = new Set();
  manifest.steps.forEach((_, step) => values(step).forEach(each => seen.add(Math.round(each))));
  return [...seen].sort((one, other) => one - other);
}

function values(step) {
  return picture.arrays[`${state.field.name}/${state.column}/${step}`];
}

function texture(bytes, filter) {
  const made = new THREE.DataTexture(bytes, bytes.length / 4, 1, THREE.RGBAFormat);
  made.minFilter = made.magFilter = filter;
  made.needsUpdate = true;
  return made;
}

function mapBytes(name) {
  const text = manifest.maps[name], bytes = new Uint8Array(4 * 256).fill(255);
  for (let k = 0; k < 256; ++k)
    for (let c = 0; c < 3; ++c) bytes[4 * k + c] = parseInt(text.substr(6 * k + 2 * c, 2), 16);
  return bytes;
}

function showColours() {
  const named = labels(), {uniforms} = picture;
  if (uniforms.map.value) uniforms.map.value.dispose();
  if (named) {
    const bytes = new Uint8Array(4 * named.length).fill(255);
    named.forEach((_, k) => [1, 3, 5].forEach((at, c) => {
      bytes[4 * k + c] = parseInt(LABEL_COLOURS[k % 12].substr(at, 2), 16);
    }));
    uniforms.map.value = texture(bytes, THREE.NearestFilter);
    [uniforms.low.value, uniforms.high.value, uniforms.bands.value] = [-0.5, named.length - 0.5, 0];
  } else {
    if (state.low === null) [state.low, state.high] = naturalRange();
    uniforms.map.value = texture(mapBytes(element("map").value), THREE.LinearFilter);
    [uniforms.low.value, uniforms.high.value] = [state.low, state.high];
    uniforms.bands.value = element("bands").checked ? 10 : 0;
  }
  const places = named && new Map(named.map((each, k) => [each, k]));
  picture.colour(values(state.step), state.field.onVertices, places);
  showLegend(named);
  eye.draw();
}

/** What a label is called: regions have names. */
function labelName(field, label) {
  return field === "region" && manifest.regionNames[label] || String(label);
}

function showLegend(named) {
  const {title, unit} = state.field, part = state.column ? ", " + state.column : "";
  element("legend_title").textContent = title + part + (unit ? ` [${unit}]` : "");
  element("legend_body").hidden = Boolean(named);
  for (const id of ["low", "high", "map", "bands", "over"]) element(id).disabled = Boolean(named);
  element("categories").innerHTML = (named || []).slice(0, 24).map((each, k) =>
    `<li><i style="background:${LABEL_COLOURS[k % 12]}"></i>${escaped(labelName(state.field.name, each))}</li>`).join("");
  if (named) return;
  element("low").value = plainNumber(state.low);
  element("high").value = plainNumber(state.high);
  const bar = element("bar").getContext("2d"), bytes = mapBytes(element("map").value);
  const bands = element("bands").checked ? 10 : 256;
  for (let row = 0; row < 256; ++row) {
    const place = (Math.floor((255 - row) / 256 * bands) + 0.5) / bands;
    const k = 4 * Math.min(255, Math.floor(256 * place));
    bar.fillStyle = `rgb(${bytes[k]},${bytes[k + 1]},${bytes[k + 2]})`;
    bar.fillRect(0, row, 1, 1);
  }
  const all = state.field.columns[state.column];
  const beyond = [Math.min(...all.map(span => span[0])) < state.low * (1 - 1e-5 * Math.sign(state.low)),
                  Math.max(...all.map(span => span[1])) > state.high * (1 + 1e-5 * Math.sign(state.high))];
  element("ticks").innerHTML = ticks(state.low, state.high).map(value => {
    const sign = value === state.low && beyond[0] ? "≤ " : value === state.high && beyond[1] ? "≥ " : "";
    const percent = 100 * (value - state.low) / (state.high - state.low);
    return `<li style="bottom:${percent}%">${sign}${shortNumber(value)}</li>`;
  }).join("");
}

/** Both ends, and between them what is round. */
function ticks(low, high) {
  const raw = (high - low) / 6, power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find(each => each * power >= raw);
  const between = [];
  for (let k = Math.ceil(low / step); k * step < high; ++k)
    if (k * step - low > 0.35 * step && high - k * step > 0.35 * step) between.push(+(k * step).toPrecision(12));
  return [low, ...between, high];
}
