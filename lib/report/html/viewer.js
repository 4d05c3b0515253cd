// The 3-D view of the report page: a mesh coloured by error, to be turned with the mouse or a finger. Bundled with the
// parts of three.js it uses into viewer.min.js by scripts/build_viewer.sh.
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Scene, WebGLRenderer
} from 'three';
import {TrackballControls} from 'three/examples/jsm/controls/TrackballControls.js';

function decode(base64, Type) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return new Type(bytes.buffer);
}

// Positions are 16-bit shares of a box, in units of its longest side; a class of error per vertex picks its colour.
function geometryOf(data) {
  const place = decode(data.positions, Uint16Array);
  const faces = decode(data.faces, Uint32Array);
  const error = decode(data.errors, Uint8Array);
  const positions = new Float32Array(place.length);
  const colors = new Float32Array(place.length);
  const palette = data.palette.map((hex) => new Color(hex));
  for (let v = 0; v < error.length; ++v) {
    for (let k = 0; k < 3; ++k) positions[3 * v + k] = (place[3 * v + k] / 65535 - 0.5) * data.box[k];
    palette[error[v]].toArray(colors, 3 * v);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('color', new BufferAttribute(colors, 3));
  geometry.setIndex(new BufferAttribute(faces, 1));
  geometry.computeVertexNormals();
  return geometry;
}

function show(holder, data) {
  const renderer = new WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  const scene = new Scene();
  scene.background = new Color('#ffffff');
  scene.add(new AmbientLight('#ffffff', 1.6));
  const lamp = new DirectionalLight('#ffffff', 1.8);
  const camera = new PerspectiveCamera(30, 1, 0.01, 100);
  camera.up.set(...data.up);
  const distance = 0.5 * Math.hypot(...data.box) / Math.tan(Math.PI / 12);
  camera.position.set(...data.view.map((x) => x * distance));
  camera.add(lamp);
  scene.add(camera);
  scene.add(new Mesh(geometryOf(data), new MeshLambertMaterial({vertexColors: true, side: DoubleSide})));
  holder.replaceChildren(renderer.domElement);
  const controls = new TrackballControls(camera, renderer.domElement);
  controls.rotateSpeed = 3;
  controls.staticMoving = true;
  const draw = () => renderer.render(scene, camera);
  const resize = () => {
    const width = holder.clientWidth, height = Math.round(width * 0.7);
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    controls.handleResize();
    draw();
  };
  controls.addEventListener('change', draw);
  window.addEventListener('resize', resize);
  const frame = () => {
    requestAnimationFrame(frame);
    controls.update();
  };
  resize();
  frame();
  holder.dataset.view = 'interactive';
}

// Where this fails (no WebGL, say) the picture that the page came with stays.
const holder = document.getElementById('view');
try {
  show(holder, JSON.parse(document.getElementById('mesh-data').textContent));
} catch (error) {
  holder.dataset.view = 'picture';
  const note = document.getElementById('view-note');
  if (note) note.textContent = 'A picture: this browser shows no 3-D graphics (' + error.message + ').';
}
