// Where the eye is, and what it sees under the mouse.

/** Where the eye is: it turns about the body's middle, and draws when something has changed. */
class Eye {
  constructor(canvas, picture) {
    this.canvas = canvas;
    this.picture = picture;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
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
    const sides = {x: [1, 0, 0], y: [0, -1, 0], z: [0, -1e-4, 1], start: [0.52, -0.9, 0.5]};
    const from = manifest.flat ? [0, 0, 1] : sides[view];
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
    const place = new THREE.Vector3();
    const away = corner => place.fromBufferAttribute(position, corner).distanceTo(found.point);
    corners.sort((one, other) => away(one) - away(other));
    return {triangle: Math.floor(corners[0] / 3), vertex: this.picture.triangles[corners[0]]};
  }
}
