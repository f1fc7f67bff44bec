// The body as three.js draws it: coloured, deformed, marked.

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

// What bodies cannot enter; its back is not drawn, so that it hides no body in front of a wall.
const obstacleShader = `
  uniform float flat2d; varying vec3 shownNormal;
  void main() {
    float key = flat2d > 0.0 ? 0.8 : max(dot(normalize(shownNormal), normalize(vec3(-0.45, 0.65, 0.75))), 0.0);
    gl_FragColor = vec4(vec3(0.62, 0.66, 0.70) * (0.72 + 0.32 * key), 1.0);
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
      vertexShader, fragmentShader: ghostShader, uniforms: this.uniforms,
      transparent: true, depthWrite: false, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2}));
    this.ghost.frustumCulled = false;
    this.place(this.ghost.geometry, this.rest);
    const vertices = new THREE.BufferAttribute(this.moved, 3);
    this.edges = this.lines(vertices, arrays.edges, {color: 0x000000, opacity: 0.30, transparent: true});
    this.outline = this.lines(new THREE.BufferAttribute(this.rest, 3), arrays.outline,
                              {color: 0x808488, opacity: 0.9, transparent: true});
    this.inside = this.lines(vertices, [], {color: 0xe61a73, opacity: 0.85, transparent: true, depthTest: false});
    this.inside.renderOrder = 1;
    this.group = new THREE.Group();
    this.group.add(this.mesh, this.edges, this.ghost, this.outline, this.inside);
    if (manifest.obstacles) this.addObstacles();
  }

  addObstacles() {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(this.arrays.obstacles), 3));
    geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(this.arrays.obstacle_triangles), 1));
    this.obstacles = new THREE.Mesh(geometry, new THREE.ShaderMaterial({
      vertexShader, fragmentShader: obstacleShader, uniforms: this.uniforms,
      polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2}));
    this.obstacles.frustumCulled = false;
    this.group.add(this.obstacles);
  }

  moveObstacles(step, factor) {
    const {arrays} = this, {geometry} = this.obstacles, {position} = geometry.attributes;
    const by = arrays["obstacles" + step];
    for (let k = 0; k < by.length; ++k) position.array[k] = arrays.obstacles[k] + factor * by[k];
    position.needsUpdate = true;
    geometry.computeVertexNormals();
  }

  /** A geometry in which no two triangles share a corner. */
  corners(more) {
    const geometry = new THREE.BufferGeometry();
    for (const name of ["position", "normal", ...more]) {
      const width = more.includes(name) ? 1 : 3;
      const numbers = new Float32Array(this.count * 3 * width);
      geometry.setAttribute(name, new THREE.BufferAttribute(numbers, width));
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
    if (this.obstacles) this.moveObstacles(step, factor);
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
