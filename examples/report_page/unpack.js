"use strict";
// The body: its arrays, the picture of them by three.js, and where the eye is.

const manifest = JSON.parse(document.getElementById("manifest").textContent);
const root = document.documentElement;

/** Says in the page why there is no picture; tests read it at the root element. */
function fail(reason) {
  root.dataset.viewer = "failed: " + reason;
  const words = document.getElementById("failure");
  words.textContent = "No picture: " + reason + ". All numbers are below.";
  words.hidden = false;
}
window.addEventListener("error", event => fail(event.message));
window.addEventListener("unhandledrejection", event => fail(String(event.reason)));

/** All arrays by name: deflated, and in each the first bytes of all numbers first. */
async function unpack() {
  const text = document.getElementById("pack").textContent.trim();
  const packed = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  if (typeof DecompressionStream === "undefined") throw "this browser is older than 2023";
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const arrays = {};
  for (const [name, [kind, start, count]] of Object.entries(manifest.index)) {
    const together = new Uint8Array(4 * count);
    for (let byte = 0; byte < 4; ++byte)
      for (let k = 0; k < count; ++k) together[4 * k + byte] = bytes[start + byte * count + k];
    arrays[name] = kind === "f" ? new Float32Array(together.buffer) : new Uint32Array(together.buffer);
  }
  return arrays;
}
