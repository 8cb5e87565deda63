// The machine and the tool path on its table: one scene at the cursor, drawn when something has changed.
const Scene = (() => {
  const { COLOURS, material, solid, pillar, makeTable, makeGuides, makePlatform, makeOwnPlate, makeRods, makeBoxes, makeMeshes, makeTriad } = Solids;

  function make(canvas, close, data, arrays) {
    const model = data.scene, rodCount = data.shapes.rods[1];
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    renderer.autoClear = false;
    const scene = new THREE.Scene(), solids = new THREE.Group(), marks = new THREE.Group();
    const camera = new THREE.PerspectiveCamera(28, 1, 1, 20000);
    camera.up.set(0, 0, 1);
    const controls = new THREE.OrbitControls(camera, canvas);
    // the close-up goes with the tip; its picture is drawn by the same renderer and copied
    const follower = camera.clone(), following = new THREE.OrbitControls(follower, close), paper = close.getContext("2d");
    following.enablePan = false;
    const lights = [[new THREE.HemisphereLight(0xffffff, 0xa9b1b9), 0.8]];
    for (const [place, strength] of [[[1.5, -2, 2.5], 0.45], [[-2, -1, 0.8], 0.2]]) {
      const light = new THREE.DirectionalLight(0xffffff);
      light.position.set(...place);
      lights.push([light, strength]);
    }
    for (const [light] of lights) scene.add(light);
    scene.add(solids);
    const table = makeTable(solids, model), guides = makeGuides(solids, model), platform = makePlatform(solids, model);
    const rods = makeRods(solids, model, rodCount), tool = new THREE.Group(), plate = makeOwnPlate(solids, model), triad = makeTriad();
    solids.add(tool);
    const stock = makeBoxes(table.part, model);
    // the nominal part, what is left of the stock, and the stock: one of them is seen
    const bodies = { ...makeMeshes(table.part, model, arrays), ...(stock.length ? { stock: { mesh: stock[0] } } : {}) };
    let bodyNow = null;
    function showBody(name) {
      bodyNow = name;
      for (const [kind, body] of Object.entries(bodies)) body.mesh.visible = kind === name;
      draw();
    }
    // the path turns with the table, and stays when the machine is hidden
    const onTable = new THREE.Group(), carrier = new THREE.Group();
    carrier.matrixAutoUpdate = false;
    carrier.add(onTable);
    scene.add(carrier, marks);

    const lines = [];
    // points of a line, or the ends of its pieces one after the other
    function wideLine(positions, colours, width, more) {
      const geometry = colours ? new THREE.LineSegmentsGeometry() : new THREE.LineGeometry();
      geometry.setPositions(positions);
      if (colours) geometry.setColors(colours);
      const line = new (colours ? THREE.LineSegments2 : THREE.Line2)(geometry, new THREE.LineMaterial({ linewidth: width, vertexColors: !!colours, ...more }));
      line.frustumCulled = false;
      onTable.add(line);
      lines.push(line);
      return line;
    }
    const trail = arrays["trail.tip"], count = trail.length / 3;
    // a retract goes far away from the part: cuts and violations are framed, rapids only where there is nothing else
    const bad = arrays["trail.bad"], rapid = arrays["trail.rapid"], pathBox = new THREE.Box3(), cutting = new Uint8Array(data.frames);
    for (let k = 0; k < count; k++) {
      if (!rapid[k]) cutting[arrays["trail.frame"][k]] = 1;
      if ((!rapid[k] || bad[k]) && Number.isFinite(trail[3 * k])) pathBox.expandByPoint(new THREE.Vector3().fromArray(trail, 3 * k));
    }
    if (pathBox.isEmpty()) pathBox.setFromArray(trail);
    const size = pathBox.getSize(new THREE.Vector3()).length() || 50;
    // the path in levels of detail: without points nearer to the last one than this, mm; from afar a coarse one looks the same
    const levels = [0, size / 3000, size / 1500, size / 800, size / 400, size / 120].map(gap => ({ gap, kept: thin(gap), line: null }));
    function thin(gap) {
      const kept = [];
      for (let k = 0, last = -1; k < count; k++) {
        // both ends of a rapid stay
        const far = last < 0 || k === count - 1 || rapid[k] !== rapid[k + 1] || Math.hypot(trail[3 * k] - trail[3 * last], trail[3 * k + 1] - trail[3 * last + 1], trail[3 * k + 2] - trail[3 * last + 2]) >= gap;
        if (far) { kept.push(k); last = k; }
      }
      return kept;
    }
    function paint(colours) {
      for (const level of levels) {
        if (level.line) { onTable.remove(level.line); level.line.geometry.dispose(); lines.splice(lines.indexOf(level.line), 1); }
        const ends = listPieces(level.kept, false);
        level.line = ends.length ? wideLine(gather(trail, ends), gather(colours, ends), 2.6) : null;
      }
    }
    const gather = (from, points) => Float32Array.from(points.flatMap(k => [from[3 * k], from[3 * k + 1], from[3 * k + 2]]));
    // both points of each piece of the path that is a rapid, or none
    function listPieces(kept, areRapid) {
      const ends = [];
      for (let i = 1; i < kept.length; i++) if (!!rapid[kept[i]] === areRapid) ends.push(kept[i - 1], kept[i]);
      return ends;
    }
    const rapids = new THREE.LineSegments(new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(gather(trail, listPieces(thin(size / 3000), true)), 3)),
      new THREE.LineBasicMaterial({ color: 0x8a949e, transparent: true, opacity: 0.8 }));
    rapids.frustumCulled = false;
    onTable.add(rapids);
    for (let k = 0; k < count; k++) {
      if (!bad[k]) continue;
      const begin = k;
      while (k + 1 < count && bad[k + 1]) k++;
      const first = Math.max(begin - 1, 0);
      if (k > first) wideLine(trail.slice(3 * first, 3 * k + 3), null, 6, { color: COLOURS.bad });
    }
    const dots = [];
    for (let k = 0; k < arrays.worst.length; k += 3) {
      if (!Number.isFinite(arrays.worst[k])) continue;
      const dot = solid(new THREE.SphereGeometry(1, 20, 14), new THREE.MeshBasicMaterial({ color: COLOURS.bad, depthTest: false }));
      dot.renderOrder = 5;
      dot.position.set(...arrays.worst.slice(k, k + 3));
      onTable.add(dot);
      dots.push(dot);
    }
    const tip = solid(new THREE.SphereGeometry(1, 20, 14), new THREE.MeshBasicMaterial({ color: 0x111111, depthTest: false }));
    tip.renderOrder = 6;
    onTable.add(tip);
    dots.push(tip);

    // tool axes, evenly spaced over the program
    const sticks = [], step = Math.max(Math.floor(data.frames / 160), 1), length = Math.min(Math.max(0.14 * size, 6), 40);
    for (let i = 0; i < data.frames; i += step) {
      const from = arrays.tip.slice(3 * i, 3 * i + 3), axis = arrays.axis.slice(3 * i, 3 * i + 3);
      if (cutting[i] && [...from, ...axis].every(Number.isFinite)) sticks.push(...from, ...from.map((value, k) => value + length * axis[k]));
    }
    const axes = new THREE.LineSegments(new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(sticks, 3)),
      new THREE.LineBasicMaterial({ color: 0x6b7580, transparent: true, opacity: 0.75 }));
    axes.frustumCulled = false;
    onTable.add(axes);

    let toolNow = "", wide = 0;  // mm; the radius at the tip
    function placeTool(frame) {
      const name = data.toolNames[arrays.tool[frame]], long = arrays.tool_length[frame], key = name + " " + long;
      if (key === toolNow) return;
      toolNow = key;
      wide = 0;
      tool.clear();
      for (const [from, to, radius] of model.tools[name] || []) {
        const end = Math.min(to === null ? long : to, long);
        if (end <= from) continue;
        const cut = to === null ? Math.min(end, from + Math.max(0.45 * (end - from), 6 * radius)) : end;
        if (from === 0) wide = radius;
        tool.add(pillar(radius, from - long, cut - long, material("cutter")));
        if (cut < end) tool.add(pillar(Math.max(radius, 0.9 * model.spindleRadius * 0.4), cut - long, end - long, material("holder")));
      }
    }

    function orient(object, from, to, along) {
      object.position.copy(from).add(to).multiplyScalar(0.5);
      object.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.copy(to).sub(from).normalize());
      object.scale.z = from.distanceTo(to);
    }
    // a vector between two frames; while it plays, the machine is drawn between them
    function blend(name, i, j, share, place, width = 3) {
      const a = arrays[name], from = width * i + place, to = width * j + place;
      return new THREE.Vector3(...[0, 1, 2].map(k => a[from + k] + share * (a[to + k] - a[from + k])));
    }
    const number = (name, i, j, share) => arrays[name][i] + share * (arrays[name][j] - arrays[name][i]);
    const spare = new THREE.Vector3();
    let frameNow = 0, reached = true, tableBeyond = false;

    function pose(i, j = i, share = 0) {
      frameNow = i;
      const joints = data.joints, q = k => arrays.q[joints.length * i + k];
      reached = Number.isFinite(q(0)) && Number.isFinite(arrays.tilt[i]);
      if (!reached || !Number.isFinite(arrays.tilt[j])) { j = i; share = 0; }
      const beyond = k => joints[k].low !== null && (q(k) < joints[k].low - 1e-6) || joints[k].high !== null && (q(k) > joints[k].high + 1e-6);
      if (Number.isFinite(arrays.tilt[i])) {
        table.tilting.quaternion.setFromAxisAngle(table.tiltAxis, number("tilt", i, j, share));
        table.turning.quaternion.setFromAxisAngle(table.turnAxis, number("turn", i, j, share));
      }
      const n = joints.length;
      tableBeyond = beyond(n - 2) || beyond(n - 1);
      const moving = [platform, tool, plate, ...rods.flatMap(rod => [rod.bar, ...rod.ends]), ...guides.map(guide => guide.slider)];
      for (const part of moving) part.visible = reached;
      if (reached) {
        const x = blend("basis", i, j, share, 0, 6).normalize(), z = blend("basis", i, j, share, 3, 6).normalize();
        const turn = new THREE.Matrix4().makeBasis(x, z.clone().cross(x), z);
        platform.position.copy(blend("platform", i, j, share, 0));
        platform.quaternion.setFromRotationMatrix(turn);
        tool.position.copy(blend("nose", i, j, share, 0));
        tool.quaternion.copy(platform.quaternion);
        placeTool(i);
        const starts = [], ends = [];
        rods.forEach((rod, k) => {
          const a = blend("rods", i, j, share, 6 * k, 6 * rodCount), b = blend("rods", i, j, share, 6 * k + 3, 6 * rodCount);
          starts.push(a);
          ends.push(b);
          orient(rod.bar, a, b, spare);
          rod.ends[0].position.copy(a);
          rod.ends[1].position.copy(b);
        });
        if (model.plate.length) {
          const along = ends[1].clone().sub(ends[0]).normalize(), normal = along.clone().cross(ends[2].clone().sub(ends[0])).normalize();
          plate.position.copy(ends[0]);
          plate.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(along, normal.clone().cross(along), normal));
        }
        for (const guide of guides) {
          guide.slider.position.set(0, 0, 0);
          for (const rod of guide.rods) guide.slider.position.addScaledVector(starts[rod], 1 / guide.rods.length);
          guide.what.color.setHex(beyond(guide.joint) ? COLOURS.bad : COLOURS.slider);
        }
      }
      table.part.updateWorldMatrix(true, false);
      carrier.matrix.copy(table.part.matrixWorld);
      carrier.updateMatrixWorld(true);
      tip.position.copy(blend("tip", i, j, share, 0));
    }
    const UPRIGHT = new THREE.Vector3(0, 0, 1), tipInScene = () => tip.getWorldPosition(new THREE.Vector3());

    // what the machine fills in all its poses
    const whole = new THREE.Box3();
    const looked = new Set(data.places.filter(frame => frame >= 0));
    for (let k = 0; k <= 50 && data.frames; k++) looked.add(Math.round(k * (data.frames - 1) / 50));
    const machineBox = () => { solids.updateMatrixWorld(true); return new THREE.Box3().setFromObject(solids); };
    for (const frame of looked) { pose(frame); if (reached) whole.union(machineBox()); }
    if (whole.isEmpty()) whole.copy(machineBox());

    function corners(bounds) {
      const list = [];
      for (let k = 0; k < 8; k++) list.push(new THREE.Vector3(k & 1 ? bounds.max.x : bounds.min.x, k & 2 ? bounds.max.y : bounds.min.y, k & 4 ? bounds.max.z : bounds.min.z));
      return list;
    }
    // from which distance an eye that looks at a centre just sees all points
    function distanceToSee(points, centre, forward, eye, border = 1.04) {
      const right = eye.up.clone().cross(forward).normalize(), up = forward.clone().cross(right);
      const high = Math.tan(THREE.MathUtils.degToRad(eye.fov / 2)) / border, wide = high * eye.aspect;
      return Math.max(1, ...points.map(point => {
        const p = point.clone().sub(centre);
        return p.dot(forward) + Math.max(Math.abs(p.dot(right)) / wide, Math.abs(p.dot(up)) / high);
      }));
    }
    function frameUp(points, direction, upright = [0, 0, 1]) {
      camera.up.set(...upright);
      const forward = direction.clone().normalize(), centre = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
      stand(centre, forward, distanceToSee(points, centre, forward, camera));
    }
    function stand(centre, direction, distance) {
      controls.target.copy(centre);
      camera.position.copy(centre).addScaledVector(direction, distance);
      camera.near = Math.max(distance / 500, 0.2);
      camera.far = distance + 8000;
      camera.updateProjectionMatrix();
      controls.update();
      draw();
    }
    const pathPoints = () => corners(around.clone().expandByScalar(Math.max(0.04 * size, 5))).map(p => p.applyMatrix4(carrier.matrix));
    // near the path, what carries the tool is glass: it hangs over the part
    const carriers = [platform, plate, ...rods.flatMap(rod => [rod.bar, ...rod.ends])];
    function glass(on) {
      const make = (part, clear, opacity) => part.traverse(one => {
        if (one.material) Object.assign(one.material, { transparent: clear, opacity: clear ? opacity : 1, depthWrite: !clear });
      });
      for (const part of carriers) make(part, on, 0.16);
      // and a cutter that hides much of what is cut
      make(tool, on && hides(), 0.4);
      // a table that is red all over would hide the red of the path on it
      table.face.color.setHex(COLOURS.table);
      if (tableBeyond) table.face.color.lerp(new THREE.Color(COLOURS.bad), on ? 0.2 : 1);
    }
    // an eye near the path sees the side of the table that the part is on: from behind it goes round the upright
    function face(direction) {
      const normal = new THREE.Vector3().setFromMatrixColumn(carrier.matrix, 2), level = Math.hypot(direction.x, direction.y) * Math.hypot(normal.x, normal.y);
      if (level < 1e-9 || direction.dot(normal) > 0.1 * direction.length()) return direction;
      const most = Math.acos(Math.min(Math.max((0.5 * direction.length() - direction.z * normal.z) / level, -1), 1));
      const angle = Math.atan2(normal.x * direction.y - normal.y * direction.x, normal.x * direction.x + normal.y * direction.y);
      return direction.applyAxisAngle(UPRIGHT, Math.min(Math.max(angle, -most), most) - angle);
    }
    function faceTable() {
      for (const [eye, turned] of through ? [[camera, controls], [follower, following]] : [[follower, following]]) {
        eye.position.copy(face(eye.position.clone().sub(turned.target)).add(turned.target));
        turned.update();
      }
    }
    let through = false;
    const standBack = (direction, upright) => { through = false; frameUp(corners(whole), direction, upright); };
    const VIEWS = {
      fit: () => standBack(new THREE.Vector3(0.8, -1.3, 0.28)),
      part: () => { through = true; frameUp(pathPoints(), face(new THREE.Vector3(0.7, -1.2, 0.7))); },
      // looking down, y is upright until the scene is turned
      top: () => standBack(new THREE.Vector3(0, -0.0001, 1), [0, 1, 0]),
      front: () => standBack(new THREE.Vector3(0, -1, 0)),
      tool: () => standBack(reached ? blend("basis", frameNow, frameNow, 0, 3, 6).add(new THREE.Vector3(0, -0.0001, 0)) : new THREE.Vector3(0, -0.0001, 1), [0, 1, 0]),
    };
    function look() {
      through = true;
      camera.up.set(0, 0, 1);
      stand(tipInScene(), face(new THREE.Vector3(0.75, -1.2, 0.45).normalize()), Math.max(5 * Math.min(size, 160), 500));
    }
    // cuts, part and stock
    const around = Object.values(bodies).reduce((all, one) => {
      one.mesh.updateMatrix();
      one.mesh.geometry.computeBoundingBox();
      return all.union(one.mesh.geometry.boundingBox.clone().applyMatrix4(one.mesh.matrix));
    }, pathBox.clone());
    // the close-up shows a part of them about the tip; while the tool is away, also the place that is nearest to it; on paper all of them
    const least = Math.max(size / 9, 6), hides = () => wide > least / 2;
    let needed = 1;
    function follow() {
      // and as wide as the cutter
      const reach = Math.max(least, 1.3 * wide), near = pathBox.clone().expandByScalar(reach);
      const onPaper = document.documentElement.classList.contains("paper"), middle = near.clampPoint(tip.position, new THREE.Vector3());
      const away = middle.distanceTo(tip.position), seen = onPaper ? around : new THREE.Box3().setFromPoints([middle, tip.position]).expandByScalar(Math.max(reach, 0.1 * away));
      const centre = seen.getCenter(new THREE.Vector3()).applyMatrix4(carrier.matrix);
      const forward = follower.position.clone().sub(following.target), nearness = forward.length() / needed;
      needed = distanceToSee(corners(seen).map(p => p.applyMatrix4(carrier.matrix)), centre, forward.normalize(), follower);
      following.target.copy(centre);
      follower.position.copy(centre).addScaledVector(forward, nearness * needed);
    }
    follower.position.set(0.75, -1.2, 0.6).normalize();
    follower.near = 1;

    let waiting = false;
    function draw() { if (!waiting) { waiting = true; requestAnimationFrame(render); } }
    function picture(eye, seeThrough, width, height) {
      glass(seeThrough);
      // marks keep their size on the screen, and of the path there is as much as the screen shows
      const perPixel = 2 * Math.tan(THREE.MathUtils.degToRad(eye.fov / 2)) / height;
      for (const dot of dots) dot.scale.setScalar((dot === tip ? 4 : 6) * perPixel * dot.getWorldPosition(spare).distanceTo(eye.position));
      const pixel = perPixel * tip.getWorldPosition(spare).distanceTo(eye.position);
      const level = levels.filter(one => one.gap <= 0.7 * pixel).pop();
      for (const one of levels) if (one.line) one.line.visible = one === level;
      for (const line of lines) line.material.resolution.set(width, height);
      renderer.setViewport(0, 0, width, height);
      renderer.clear();
      renderer.render(scene, eye);
    }
    function render() {
      waiting = false;
      const width = canvas.clientWidth, height = canvas.clientHeight, wide = Math.min(close.clientWidth, width), high = Math.min(close.clientHeight, height);
      if (!width || !height) return;
      if (wide && high) {
        follower.aspect = wide / high;
        follow();
        follower.far = follower.position.distanceTo(following.target) + 4000;
        follower.updateProjectionMatrix();
        follower.lookAt(following.target);
        picture(follower, true, wide, high);
        const ratio = renderer.getPixelRatio(), w = Math.round(wide * ratio), h = Math.round(high * ratio);
        if (close.width !== w || close.height !== h) { close.width = w; close.height = h; }
        paper.clearRect(0, 0, w, h);
        paper.drawImage(canvas, 0, canvas.height - h, w, h, 0, 0, w, h);
      }
      picture(camera, through, width, height);
      renderer.clearDepth();
      const side = Math.min(96, 0.3 * width);
      renderer.setViewport(6, 6, side, side);
      triad.camera.position.copy(camera.position).sub(controls.target).normalize().multiplyScalar(5);
      triad.camera.up.copy(camera.up);
      triad.camera.lookAt(0, 0, 0);
      renderer.render(triad.scene, triad.camera);
    }
    function resize() {
      const width = canvas.clientWidth, height = canvas.clientHeight;
      if (!width || !height) return;
      const onPaper = document.documentElement.classList.contains("paper");
      renderer.setPixelRatio(onPaper ? 2 : Math.min(window.devicePixelRatio || 1, 2));
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      draw();
    }
    controls.addEventListener("change", draw);
    following.addEventListener("change", draw);
    controls.addEventListener("start", () => camera.up.set(0, 0, 1));

    // the point of the path under a place of the picture, or of the close-up; -1 where none is near
    function pick(x, y, isClose = false) {
      const [eye, element] = isClose ? [follower, close] : [camera, canvas];
      eye.updateMatrixWorld();
      const near = 14, point = new THREE.Vector3();
      let best = -1, least = near * near;
      for (let k = 0; k < count; k++) {
        if (rapid[k] && !rapids.visible) continue;
        point.set(trail[3 * k], trail[3 * k + 1], trail[3 * k + 2]).applyMatrix4(carrier.matrix).project(eye);
        const dx = (point.x + 1) / 2 * element.clientWidth - x, dy = (1 - point.y) / 2 * element.clientHeight - y, d = dx * dx + dy * dy;
        if (d < least) { least = d; best = k; }
      }
      return best;
    }
    // what is known of the part under a place of the picture: deviation (NaN: no cutter comes near) and the frame that does it
    const ray = new THREE.Raycaster();
    function probe(x, y, isClose = false) {
      const [eye, element] = isClose ? [follower, close] : [camera, canvas], body = bodies[bodyNow];
      if (!body || !body.value || !solids.visible) return null;
      eye.updateMatrixWorld();
      ray.setFromCamera({ x: 2 * x / element.clientWidth - 1, y: 1 - 2 * y / element.clientHeight }, eye);
      const [hit] = ray.intersectObject(body.mesh);
      return hit ? { value: body.value[hit.faceIndex], frame: body.frame[hit.faceIndex], place: hit.point.toArray() } : null;
    }
    // points in the canvas: -1 to 1
    function onScreen(points) {
      camera.updateMatrixWorld();
      return points.map(point => point.project(camera).toArray());
    }

    return {
      pose: (...where) => { pose(...where); faceTable(); }, draw, render, paint, resize, pick, probe, showBody, bodies: Object.keys(bodies), look, camera, tipInScene, reached: () => reached,
      view: name => VIEWS[name](), show: on => { solids.visible = on; draw(); }, showAxes: on => { axes.visible = on; draw(); },
      showRapids: on => { rapids.visible = on; draw(); },
      dark: on => { for (const [light, strength] of lights) light.intensity = (on ? 0.75 : 1) * strength; tip.material.color.setHex(on ? 0xffffff : 0x111111); axes.material.color.setHex(on ? 0xffffff : 0x5a636c); draw(); },
      machineOnScreen: () => onScreen(corners(machineBox())), tipOnScreen: () => onScreen([tipInScene()])[0], inCloseUp: points => { follow(); follower.updateMatrixWorld(); return points.map(p => new THREE.Vector3(...p).applyMatrix4(carrier.matrix).project(follower).toArray()); },
      tipInCloseUp: () => { follow(); follower.updateMatrixWorld(); return tipInScene().project(follower).toArray(); },
      pathOnScreen: () => onScreen(corners(pathBox).map(p => p.applyMatrix4(carrier.matrix))), showsRapids: () => rapids.visible,
      toolEnds: () => [tool.getWorldPosition(new THREE.Vector3()).toArray(), tipInScene().toArray()],
    };
  }
  return { make };
})();
