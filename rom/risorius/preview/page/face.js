// Draws the face: the vertices that the server sends for each frame, and companions by the lift coordinates.
import { Sliders } from "./sliders.js";

const TICKET_BYTES = 4;
const FLOAT_BYTES = 4;
const FACE_PATH = ["meshcat", "face"];
const OBJECT = "<object>";
const MARGIN = 0.86; // share of the window that the face fills on load
const RETRY_MS = 1000;

export class FacePreview {
  constructor(viewer, statusLine) {
    this.viewer = viewer;
    this.statusLine = statusLine;
    this.mesh = null;
    this.companions = []; // [mesh, change of its matrix with each of the first coordinates]
    this.pending = null;
    this.drawIsDue = false;
    this.shown = -1; // sequence number of the frame in the window
    this.lost = false;
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/face`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { if (this.lost) location.reload(); };
    this.socket.onmessage = (event) => this.receive(event.data);
    this.socket.onclose = () => {
      this.lost = true;
      this.report("connection lost, trying again", true);
      setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  receive(data) {
    if (typeof data === "string") return this.setUp(JSON.parse(data));
    const { lifts, vertices } = this.setup;
    const verticesStart = TICKET_BYTES + FLOAT_BYTES * lifts;
    const statusStart = verticesStart + 3 * FLOAT_BYTES * vertices;
    const status = JSON.parse(new TextDecoder().decode(new Uint8Array(data, statusStart)));
    this.sliders.display(status.values);
    this.pending = {
      ticket: new Uint32Array(data, 0, 1)[0],
      q: new Float32Array(data, TICKET_BYTES, lifts),
      x: new Float32Array(data, verticesStart, 3 * vertices),
      status,
    };
    this.scheduleDrawing();
  }

  setUp(setup) {
    this.setup = setup;
    document.title = `${setup.model} – Risorius`;
    this.sliders = new Sliders(this.viewer.gui, setup, (moves) => this.send({ inputs: moves }));
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  // A hidden window gets no animation frames: nothing is drawn or acknowledged until it is looked at again.
  scheduleDrawing() {
    if (this.drawIsDue) return;
    this.drawIsDue = true;
    requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.drawIsDue = false;
    if (!this.mesh && !this.findMesh()) return this.scheduleDrawing(); // meshcat's own socket brings it
    const { ticket, q, x, status } = this.pending;
    this.deform(x);
    this.pose(q);
    computeNormals(this.mesh.geometry);
    this.viewer.render();
    this.describe(status);
    this.shown = status.sequence;
    this.send({ drawn: ticket });
  }

  findMesh() {
    const find = (...path) => this.viewer.scene_tree.find([...FACE_PATH, ...path, OBJECT]).object;
    const object = find();
    if (!object.isMesh) return false;
    this.mesh = object;
    this.mesh.frustumCulled = false; // the bounding sphere of the rest pose does not hold for others
    this.companions = Object.entries(this.setup.companions).map(([name, changes]) => [find(name), changes]);
    for (const [companion] of this.companions) companion.matrixAutoUpdate = false;
    this.frameFace();
    return true;
  }

  deform(x) {
    const { position } = this.mesh.geometry.attributes;
    position.array.set(x);
    position.needsUpdate = true;
  }

  // The motion of a companion is linear in the coordinates of the jaw, which come first.
  pose(q) {
    for (const [companion, changes] of this.companions) {
      const { elements } = companion.matrix.identity();
      changes.forEach((change, k) => change.forEach((value, i) => { elements[i] += q[k] * value; }));
      companion.matrixWorldNeedsUpdate = true;
    }
  }

  // Moves the camera, without turning it, to where face and companions just fit in the middle beside the panel.
  frameFace() {
    const { Box3, MathUtils, Vector2, Vector3 } = MeshCat.THREE;
    const { camera, renderer, controls, scene } = this.viewer;
    const { x: width, y: height } = renderer.getSize(new Vector2());
    const covered = this.sliders.coveredWidth;
    camera.setViewOffset(width, height, covered / 2, 0, width, height);
    controls.update();
    scene.updateMatrixWorld(true);
    const toCamera = camera.matrixWorldInverse.clone().multiply(this.mesh.matrixWorld);
    const points = [];
    for (const { geometry } of [this.mesh, ...this.companions.map(([companion]) => companion)]) {
      const { array } = geometry.attributes.position;
      for (let i = 0; i < array.length; i += 3) points.push(new Vector3().fromArray(array, i).applyMatrix4(toCamera));
    }
    const centre = new Box3().setFromPoints(points).getCenter(new Vector3());
    const tangent = MARGIN * Math.tan(MathUtils.degToRad(camera.fov / 2));
    const aspect = (width - covered) / height;
    let distance = 0;
    for (const point of points) {
      point.sub(centre);
      distance = Math.max(distance, point.z + Math.max(Math.abs(point.y), Math.abs(point.x) / aspect) / tangent);
    }
    const backwards = camera.position.clone().normalize();
    controls.target.copy(centre.applyMatrix4(camera.matrix));
    camera.position.copy(controls.target).addScaledVector(backwards, distance);
  }

  describe(status) {
    if (!status.method) return this.report(this.setup.model, false);
    const error = status.error === null ? "error unknown" : `error ≤ ${(1e3 * status.error).toPrecision(2)} mm`;
    const text = `${this.setup.model} · ${status.method} · ${error} · ${(1e6 * status.elapsed).toFixed(0)} µs`;
    this.report(status.converged ? text : `${text} · not converged: last good state`, !status.converged);
  }

  report(text, isWarning) {
    this.statusLine.textContent = text;
    this.statusLine.classList.toggle("warning", isWarning);
  }
}

// Vertex normals weighted by triangle area, without allocating.
function computeNormals(geometry) {
  const x = geometry.attributes.position.array;
  const normal = geometry.attributes.normal;
  const n = normal.array;
  const index = geometry.index.array;
  n.fill(0);
  for (let t = 0; t < index.length; t += 3) {
    const a = 3 * index[t], b = 3 * index[t + 1], c = 3 * index[t + 2];
    const ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
    const vx = x[c] - x[a], vy = x[c + 1] - x[a + 1], vz = x[c + 2] - x[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    n[a] += nx; n[a + 1] += ny; n[a + 2] += nz;
    n[b] += nx; n[b + 1] += ny; n[b + 2] += nz;
    n[c] += nx; n[c + 1] += ny; n[c + 2] += nz;
  }
  for (let i = 0; i < n.length; i += 3) {
    const length = Math.hypot(n[i], n[i + 1], n[i + 2]) || 1; // a vertex without triangles has no normal
    n[i] /= length; n[i + 1] /= length; n[i + 2] /= length;
  }
  normal.needsUpdate = true;
}
