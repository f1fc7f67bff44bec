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

const NOTHING = -1e38;  // stands for a value that is no number

const vertexShader = `
  attribute float value; attribute float marked;
  varying float shownValue; varying float shownMark; varying vec3 shownNormal;
  void main() {
    shownValue = value; shownMark = marked; shownNormal = normalMatrix * normal;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;
const fragmentShader = `
  uniform sampler2D map; uniform float low, high, bands, flat2d, marks;
  varying float shownValue; varying float shownMark; varying vec3 shownNormal;
  void main() {
    float place = clamp((shownValue - low) / (high - low), 0.0, 1.0);
    if (bands > 0.0) place = (min(floor(place * bands), bands - 1.0) + 0.5) / bands;
    vec3 colour = shownValue < -1e30 ? vec3(0.55) : texture2D(map, vec2(place, 0.5)).rgb;
    bool stripe = mod(gl_FragCoord.x + gl_FragCoord.y, 12.0) < 6.0;
    if (marks > 0.0 && shownMark > 0.5) colour = stripe ? vec3(0.90, 0.10, 0.45) : vec3(1.0);
    if (flat2d > 0.0) { gl_FragColor = vec4(colour, 1.0); return; }
    vec3 n = normalize(shownNormal);
    if (!gl_FrontFacing) { n = -n; colour = mix(colour, vec3(0.35, 0.31, 0.30), 0.65); }
    float key = max(dot(n, normalize(vec3(-0.45, 0.65, 0.75))), 0.0);
    float fill = max(dot(n, normalize(vec3(0.8, -0.1, 0.45))), 0.0);
    float shine = pow(max(dot(n, normalize(vec3(-0.24, 0.35, 0.92))), 0.0), 24.0);
    gl_FragColor = vec4(colour * (0.70 + 0.32 * key + 0.10 * fill) + 0.06 * shine, 1.0);
  }`;
// The body at rest, as a breath of grey that is densest at its rim.
const ghostShader = `
  uniform float flat2d; varying vec3 shownNormal;
  void main() {
    float facing = flat2d > 0.0 ? 1.0 : abs(normalize(shownNormal).z);
    gl_FragColor = vec4(0.5, 0.52, 0.54, 0.10 + 0.42 * pow(1.0 - facing, 2.5));
  }`;

/** The body in the scene of three.js; `show` colours it, `move` deforms it. */
class BodyPicture {
  constructor(arrays) {
    this.arrays = arrays;
    this.triangles = arrays.triangles;
    this.count = this.triangles.length / 3;
    this.rest = arrays.rest;
    this.moved = new Float32Array(this.rest);  // of the vertices
    this.sums = new Float32Array(3 * (1 + largest(arrays.smooth)));
    this.geometry = this.corners(["value", "marked"]);
    this.uniforms = {map: {value: null}, low: {value: 0}, high: {value: 1}, bands: {value: 0},
                     flat2d: {value: manifest.flat ? 1 : 0}, marks: {value: 1}};
    const material = new THREE.ShaderMaterial({
      vertexShader, fragmentShader, uniforms: this.uniforms, side: THREE.DoubleSide,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1});
    this.mesh = new THREE.Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
    this.ghost = new THREE.Mesh(this.corners([]), new THREE.ShaderMaterial({
      vertexShader, fragmentShader: ghostShader, uniforms: this.uniforms, transparent: true, depthWrite: false,
      polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2}));
    this.ghost.frustumCulled = false;
    this.place(this.ghost.geometry, this.rest);
    const vertices = new THREE.BufferAttribute(this.moved, 3);
    this.edges = this.lines(vertices, arrays.edges, {color: 0x000000, opacity: 0.30, transparent: true});
    this.outline = this.lines(new THREE.BufferAttribute(this.rest, 3), arrays.outline,
                              {color: 0x808488, opacity: 0.9, transparent: true});
    this.inside = this.lines(vertices, [], {color: 0xe61a73, depthTest: false, transparent: true, opacity: 0.85});
    this.inside.renderOrder = 1;
    this.group = new THREE.Group();
    this.group.add(this.mesh, this.edges, this.ghost, this.outline, this.inside);
  }

  /** A geometry in which no two triangles share a corner. */
  corners(more) {
    const geometry = new THREE.BufferGeometry();
    for (const name of ["position", "normal", ...more]) {
      const width = more.includes(name) ? 1 : 3;
      geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(this.count * 3 * width), width));
    }
    return geometry;
  }

  lines(vertices, pairs, look) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", vertices);
    geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(pairs), 1));
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial(look));
    lines.frustumCulled = false;
    return lines;
  }

  /** Positions are rest + factor * displacement of a step; normals follow. */
  move(step, factor) {
    const u = this.arrays["u" + step], {rest, moved} = this;
    for (let k = 0; k < rest.length; ++k) moved[k] = rest[k] + factor * u[k];
    this.place(this.geometry, moved);
    this.edges.geometry.attributes.position.needsUpdate = true;
    const marked = this.geometry.attributes.marked.array.fill(0);
    for (const t of this.arrays["marked" + step]) marked.fill(1, 3 * t, 3 * t + 3);
    this.geometry.attributes.marked.needsUpdate = true;
    this.inside.geometry.setIndex(new THREE.BufferAttribute(this.arrays["inside" + step], 1));
  }

  /** Corners from `points` of the vertices, with normals that are smooth but at the body's edges. */
  place(geometry, points) {
    const {triangles, sums} = this, smooth = this.arrays.smooth;
    const position = geometry.attributes.position.array, normal = geometry.attributes.normal.array;
    for (let corner = 0; corner < triangles.length; ++corner)
      for (let axis = 0; axis < 3; ++axis)
        position[3 * corner + axis] = points[3 * triangles[corner] + axis];
    sums.fill(0);
    for (let t = 0; t < triangles.length; t += 3) {
      const [ax, ay, az, bx, by, bz, cx, cy, cz] = position.subarray(3 * t, 3 * t + 9);
      const px = bx - ax, py = by - ay, pz = bz - az, qx = cx - ax, qy = cy - ay, qz = cz - az;
      const nx = py * qz - pz * qy, ny = pz * qx - px * qz, nz = px * qy - py * qx;
      for (let k = 0; k < 3; ++k) {
        const at = 3 * smooth[t + k];
        sums[at] += nx; sums[at + 1] += ny; sums[at + 2] += nz;
      }
    }
    for (let corner = 0; corner < triangles.length; ++corner) {
      const at = 3 * smooth[corner];
      const size = Math.hypot(sums[at], sums[at + 1], sums[at + 2]) || 1;
      for (let axis = 0; axis < 3; ++axis) normal[3 * corner + axis] = sums[at + axis] / size;
    }
    geometry.attributes.position.needsUpdate = geometry.attributes.normal.needsUpdate = true;
    geometry.boundingSphere = geometry.boundingBox = null;
  }

  /** Values a corner, from a field's column on vertices or cells. `places`: labels to numbers. */
  colour(values, onVertices, places) {
    const shown = this.geometry.attributes.value.array;
    for (let corner = 0; corner < shown.length; ++corner) {
      const row = onVertices ? this.triangles[corner] : this.arrays.triangle_cells[Math.floor(corner / 3)];
      const value = places ? places.get(Math.round(values[row])) : values[row];
      shown[corner] = Number.isFinite(value) ? value : NOTHING;
    }
    this.geometry.attributes.value.needsUpdate = true;
  }

  /** Leaves only the triangles and edges of some regions. */
  showRegions(regions) {
    const of = this.arrays.triangle_regions;
    const shown = [], touched = new Uint8Array(this.rest.length / 3);
    for (let t = 0; t < this.count; ++t) {
      if (!regions.has(of[t])) continue;
      shown.push(3 * t, 3 * t + 1, 3 * t + 2);
      for (let k = 0; k < 3; ++k) touched[this.triangles[3 * t + k]] = 1;
    }
    this.geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(shown), 1));
    const pairs = [], all = this.arrays.edges;
    for (let k = 0; k < all.length; k += 2)
      if (touched[all[k]] && touched[all[k + 1]]) pairs.push(all[k], all[k + 1]);
    this.edges.geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(pairs), 1));
  }
}

function largest(numbers) {
  return numbers.reduce((most, each) => Math.max(most, each), 0);
}

/** Where the eye is: it turns about the body's middle, and draws when something has changed. */
class Eye {
  constructor(canvas, picture) {
    this.canvas = canvas;
    this.picture = picture;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.scene = new THREE.Scene();
    this.scene.add(picture.group);
    this.camera = manifest.flat ? new THREE.OrthographicCamera(-1, 1, 1, -1)
                                : new THREE.PerspectiveCamera(28, 1);
    this.camera.up.set(0, manifest.flat ? 1 : 0, manifest.flat ? 0 : 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableKeys = false;  // these listen everywhere; ours only on the canvas
    this.controls.enableRotate = !manifest.flat;
    if (manifest.flat) this.controls.mouseButtons.LEFT = THREE.MOUSE.PAN;
    if (manifest.flat) this.controls.touches.ONE = THREE.TOUCH.PAN;
    this.controls.addEventListener("change", () => this.draw());
    this.raycaster = new THREE.Raycaster();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
    if (width === this.width && height === this.height) return;
    Object.assign(this, {width, height});
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    if (this.radius) this.shape();
    this.draw();
  }

  /** Pixels at the left that the legend covers. */
  get margin() {
    const legend = document.getElementById("legend");
    return this.width > 560 ? legend.offsetLeft + legend.offsetWidth : 0;
  }

  /** Width over height of what the legend leaves free. */
  get freeAspect() {
    return (this.width - this.margin) / Math.max(this.height, 1);
  }

  /** The camera's shape for the window and the body's size; the middle is that of the free part. */
  shape() {
    const aspect = this.width / Math.max(this.height, 1);
    if (manifest.flat) {
      const half = 1.12 * Math.max(this.half.y, this.half.x / this.freeAspect, 1e-9 * this.radius);
      Object.assign(this.camera, {left: -half * aspect, right: half * aspect, top: half, bottom: -half});
    } else {
      this.camera.aspect = aspect;
    }
    this.camera.setViewOffset(this.width, this.height, -this.margin / 2, 0, this.width, this.height);
  }

  /** Looks at all of the body from the side `view`: start, x, y or z. */
  look(view) {
    const box = new THREE.Box3().setFromArray(this.picture.moved);
    box.union(new THREE.Box3().setFromArray(this.picture.rest));
    const middle = box.getCenter(new THREE.Vector3());
    this.half = box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    this.radius = this.half.length() || 1;
    const from = manifest.flat ? [0, 0, 1] : {x: [1, 0, 0], y: [0, -1, 0], z: [0, -1e-4, 1]}[view] || [0.52, -0.9, 0.5];
    const away = new THREE.Vector3(...from).normalize();
    const distance = manifest.flat ? 2 * this.radius : this.tightDistance(away, middle);
    this.camera.zoom = 1;
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(away, distance);
    this.shape();
    this.controls.update();
    this.draw();
  }

  /** The least distance at which every vertex is in the picture, with a margin. */
  tightDistance(away, middle) {
    const right = new THREE.Vector3().crossVectors(this.camera.up, away).normalize();
    const up = new THREE.Vector3().crossVectors(away, right);
    const tall = Math.tan(this.camera.fov * Math.PI / 360) * 0.88, wide = tall * this.freeAspect;
    const point = new THREE.Vector3();
    let distance = 0;
    for (const points of [this.picture.moved, this.picture.rest])
      for (let k = 0; k < points.length; k += 3) {
        point.fromArray(points, k).sub(middle);
        const reach = Math.max(Math.abs(point.dot(right)) / wide, Math.abs(point.dot(up)) / tall);
        distance = Math.max(distance, reach + point.dot(away));
      }
    return distance || 1;
  }

  turn(across, upwards) {
    if (manifest.flat) return;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const toZ = new THREE.Quaternion().setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    const sphere = new THREE.Spherical().setFromVector3(offset.applyQuaternion(toZ));
    sphere.theta += across;
    sphere.phi += upwards;
    sphere.makeSafe();
    offset.setFromSpherical(sphere).applyQuaternion(toZ.conjugate());
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  zoom(factor) {
    if (manifest.flat) {
      this.camera.zoom /= factor;
      this.camera.updateProjectionMatrix();
    } else {
      this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    }
    this.controls.update();
    this.draw();
  }

  draw() {
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => { this.waiting = 0; this.drawNow(); });
  }

  drawNow() {
    if (!this.radius) return;
    const distance = this.camera.position.distanceTo(this.controls.target);
    const reach = 2.5 * this.radius + this.controls.target.length();
    this.camera.near = Math.max(distance - reach, 1e-3 * distance);
    this.camera.far = distance + reach;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
    this.drawTriad();
  }

  /** Which way the axes point. */
  drawTriad() {
    const turned = new THREE.Matrix3().getNormalMatrix(this.camera.matrixWorldInverse);
    const axes = (manifest.flat ? "xy" : "xyz").split("").map((name, k) => {
      const end = new THREE.Vector3().setComponent(k, 1).applyMatrix3(turned);
      return {name, end, colour: ["#c4453a", "#3f8f3a", "#3a6fc4"][k]};
    }).sort((one, other) => one.end.z - other.end.z);
    document.getElementById("triad").innerHTML = axes.map(({name, end, colour}) =>
      `<path d="M0 0L${30 * end.x} ${-30 * end.y}" stroke="${colour}" stroke-width="2"/>` +
      `<text x="${41 * end.x}" y="${-41 * end.y}" fill="${colour}">${name}</text>`).join("");
  }

  /** The triangle under a place of the window, and which of its corners is nearest; or nothing. */
  hit(x, y) {
    const frame = this.canvas.getBoundingClientRect();
    this.raycaster.setFromCamera({x: 2 * (x - frame.left) / frame.width - 1,
                                  y: 1 - 2 * (y - frame.top) / frame.height}, this.camera);
    const found = this.raycaster.intersectObject(this.picture.mesh)[0];
    if (!found) return null;
    const corners = [found.face.a, found.face.b, found.face.c];
    const position = this.picture.geometry.attributes.position;
    const away = corner => new THREE.Vector3().fromBufferAttribute(position, corner).distanceTo(found.point);
    corners.sort((one, other) => away(one) - away(other));
    return {triangle: Math.floor(corners[0] / 3), vertex: this.picture.triangles[corners[0]]};
  }
}
