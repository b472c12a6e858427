// Standing in the room with a headset (WebXR): the trigger, a pinch or the stick pushed ahead aims, and letting go moves there; the stick
// pushed aside turns. The bundled three.js speaks an older WebXR, so this draws into the headset's framebuffer by itself.

const snap_turn = Math.PI / 6;
const head_m = 1.85;

/// Where a visitor may stand: `floor`, a height, and `allows(east, north)`: where floor was scanned, and nothing is in the way from the
/// shins to the head.
function standingRoom(ground) {
    const [[west, east], [south, north], [low, high]] = ground.ends;
    const floor = floorOf(ground.triangles, low, high);
    const plan = planOf(ground.triangles, [west, south], [east, north], floor + head_m - 0.15, head_m - 0.45);
    const allows = (east, north) => {
        const [column, row] = cellAt(plan, east, north);
        return roomAt(plan, east, north) >= 0 && plan.grounds[row * plan.columns + column] < 3 * cell_m;
    };
    return { floor, allows };
}

/// The path of something thrown, [east, north, up] each, down to the floor; empty if it starts below or never comes down in the room.
function thrown(from, direction, floor) {
    const path = [];
    for (let seconds = 0; seconds < 3 && from[2] > floor; seconds += 0.03) {
        const at = from.map((value, axis) => value + 5.5 * seconds * direction[axis] - (axis === 2 ? 4.9 * seconds * seconds : 0));
        path.push(at);
        if (at[2] <= floor) {
            at[2] = floor;
            return path;
        }
    }
    return [];
}

/// Ends with the session. `viewer` as showRoom gives it.
async function enterVr(viewer) {
    const { renderer, scene, ground, worldOf } = viewer;
    const session = await navigator.xr.requestSession("immersive-vr", { requiredFeatures: ["local-floor"] });
    const gl = renderer.getContext();
    await gl.makeXRCompatible();
    const layer = new XRWebGLLayer(session, gl);
    session.updateRenderState({ baseLayer: layer, depthNear: 0.05, depthFar: 200 });
    if (session.supportedFrameRates?.includes(72))
        session.updateTargetFrameRate(72).catch(() => {});  // It goes on at its own rate.
    const space = await session.requestReferenceSpace("local-floor");

    const { floor, allows } = standingRoom(ground);
    const begin = viewer.here();
    let [east, north, yaw] = [begin.east, begin.north, begin.yaw];  // Of the headset's origin, on the floor.
    let head = null;  // East, north and up.
    const room_from_headset = new THREE.Matrix4();
    const place = () => {
        const ahead = worldOf([Math.cos(yaw), Math.sin(yaw), 0]), up = ground.axes[2];
        room_from_headset.makeBasis(ahead.clone().cross(up), up, ahead.clone().negate()).setPosition(worldOf([east, north, floor]));
    };
    const axesOf = vector => ground.axes.map(axis => vector.dot(axis));
    const inRoom = ({ x, y, z }) => axesOf(new THREE.Vector3(x, y, z).applyMatrix4(room_from_headset));
    const moveHead = to => {
        [east, north] = [east + to[0] - head[0], north + to[1] - head[1]];
        place();
    };
    place();

    const ring = new THREE.Mesh(new THREE.RingBufferGeometry(0.16, 0.22, 40), new THREE.MeshBasicMaterial({ side: THREE.DoubleSide }));
    ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), ground.axes[2]);
    const arc = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial());
    arc.frustumCulled = false;
    scene.add(ring, arc);

    const pressed = new Set(), aiming = new Map(), turned = new Set();  // aiming: the place aimed at, or null where nobody may stand.
    session.addEventListener("selectstart", ({ inputSource }) => pressed.add(inputSource));
    session.addEventListener("selectend", ({ inputSource }) => pressed.delete(inputSource));
    const aim = (source, pose) => {
        const { position, matrix } = pose.transform;
        const direction = axesOf(new THREE.Vector3(-matrix[8], -matrix[9], -matrix[10]).transformDirection(room_from_headset));
        const path = thrown(inRoom(position), direction, floor);
        const end = path.at(-1);
        aiming.set(source, end && allows(end[0], end[1]) ? end : null);
        ring.visible = Boolean(end);
        arc.visible = path.length > 1;
        arc.geometry.dispose();
        arc.geometry = new THREE.BufferGeometry().setFromPoints(path.map(worldOf));
        if (end)
            ring.position.copy(worldOf([end[0], end[1], floor + 0.02]));
        for (const { material } of [ring, arc])
            material.color.setHex(aiming.get(source) ? 0x74aef2 : 0xd05050);
    };
    const act = frame => {
        ring.visible = arc.visible = false;
        for (const source of session.inputSources) {
            const [x, y] = (source.gamepad?.axes.length ?? 0) > 3 ? source.gamepad.axes.slice(2) : source.gamepad?.axes ?? [];
            const pose = frame.getPose(source.targetRaySpace, space);
            if (pose && (pressed.has(source) || y < (aiming.has(source) ? -0.3 : -0.7)))
                aim(source, pose);
            else if (aiming.has(source)) {
                const to = aiming.get(source);
                aiming.delete(source);
                if (to)
                    moveHead(to);
            }
            if (Math.abs(x) > 0.7 && !turned.has(source)) {
                turned.add(source);
                const angle = x > 0 ? -snap_turn : snap_turn, [de, dn] = [east - head[0], north - head[1]];
                yaw += angle;
                east = head[0] + de * Math.cos(angle) - dn * Math.sin(angle);
                north = head[1] + de * Math.sin(angle) + dn * Math.cos(angle);
                place();
            } else if (!(Math.abs(x) > 0.3))
                turned.delete(source);
        }
    };

    const ratio = renderer.getPixelRatio(), eye = new THREE.Camera();
    eye.matrixAutoUpdate = false;
    renderer.setPixelRatio(1);
    renderer.autoClear = false;
    const draw = (_, frame) => {
        session.requestAnimationFrame(draw);
        const pose = frame.getViewerPose(space);
        if (!pose)
            return;
        const entering = head === null;
        head = inRoom(pose.transform.position);
        if (entering)
            moveHead([begin.east, begin.north]);
        act(frame);
        head = inRoom(pose.transform.position);
        renderer.setFramebuffer(layer.framebuffer);
        renderer.setRenderTarget(null);
        renderer.clear();
        for (const view of pose.views) {
            const { x, y, width, height } = layer.getViewport(view);
            renderer.setViewport(x, y, width, height);
            eye.matrix.fromArray(view.transform.matrix).premultiply(room_from_headset);
            eye.matrixWorldNeedsUpdate = true;
            eye.projectionMatrix.fromArray(view.projectionMatrix);
            renderer.render(scene, eye);
        }
    };
    viewer.vr = { head: () => head, yaw: () => yaw, floor, allows };
    session.addEventListener("end", () => {
        delete viewer.vr;
        scene.remove(ring, arc);
        renderer.setFramebuffer(null);
        renderer.setRenderTarget(null);
        renderer.autoClear = true;
        renderer.setPixelRatio(ratio);
        viewer.resize();
    });
    session.requestAnimationFrame(draw);
}

/// Shows the button where the browser has a headset.
async function offerVr(button, viewer, tell) {
    if (!await navigator.xr?.isSessionSupported("immersive-vr").catch(() => false))
        return;
    button.hidden = false;
    button.addEventListener("click", () => enterVr(viewer).catch(error => tell(`VR cannot begin: ${error.message}`)));
}
