// The textured mesh in WebGL: walked through, or turned from outside.

function bytesOf(base64) {
    const text = atob(base64);
    const result = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i)
        result[i] = text.charCodeAt(i);
    return result.buffer;
}

const background = 0x20242a;
const vector = values => new THREE.Vector3().fromArray(values);

async function textureOf(uri, anisotropy) {
    const picture = new Image();
    picture.src = uri;
    await picture.decode();
    const texture = new THREE.Texture(picture);
    texture.anisotropy = anisotropy;
    texture.needsUpdate = true;
    return texture;
}

/// What texture.mix computes, for any shares: in the values of its pictures, as it does.
async function mixingMaterial(mixture, anisotropy) {
    const uniforms = { color: { value: mixture.color }, strokes: { value: mixture.strokes } };
    for (const name of ["photo", "colors", "painted"])
        uniforms[name] = { value: await textureOf(mixture[name], anisotropy) };
    return new THREE.ShaderMaterial({
        uniforms,
        vertexShader: "varying vec2 at; void main() { at = uv; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
        fragmentShader: `
            uniform sampler2D photo, colors, painted; uniform float color, strokes; varying vec2 at;
            void main() {
                vec3 p = texture2D(photo, at).rgb, c = texture2D(colors, at).rgb, s = texture2D(painted, at).rgb;
                gl_FragColor = vec4(clamp(p + color * (c - p) + strokes * (s - c), 0.0, 1.0), 1.0);
            }`,
    });
}

const over_surface = "varying vec2 at; varying vec3 place; void main() { at = uv; place = (modelMatrix * vec4(position, 1.0)).xyz; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }";

/// The colors under a lamp that can be moved, with a little light from everywhere; the gloss is that of microfacets (GGX, Walter et al. 2007). `reach`:
/// how far the lamp lights.
async function litMaterial(room, relief, anisotropy) {
    const uniforms = { lamp: { value: new THREE.Vector3() }, reach: { value: 1 } };
    for (const [name, uri] of [["colors", room.texture], ["normals", relief.normals], ["roughness", relief.roughness]])
        uniforms[name] = { value: await textureOf(uri, anisotropy) };
    return new THREE.ShaderMaterial({
        uniforms,
        vertexShader: over_surface,
        fragmentShader: `
            uniform sampler2D colors, normals, roughness; uniform vec3 lamp; uniform float reach; varying vec2 at; varying vec3 place;
            void main() {
                vec3 color = pow(texture2D(colors, at).rgb, vec3(2.2)), n = normalize(texture2D(normals, at).rgb * 2.0 - 1.0);
                vec3 to_lamp = lamp - place, l = normalize(to_lamp), v = normalize(cameraPosition - place), h = normalize(l + v);
                float rough = texture2D(roughness, at).r, a = rough * rough, falling = max(dot(n, l), 0.0), seen = max(dot(n, v), 0.05);
                float wide = dot(n, h) * dot(n, h) * (a * a - 1.0) + 1.0, k = a / 2.0;
                float gloss = 0.04 * a * a / (4.0 * wide * wide * (falling * (1.0 - k) + k) * (seen * (1.0 - k) + k));
                vec3 light = color * 0.25 + (color + gloss) * falling * 1.9 / (1.0 + 4.0 * dot(to_lamp, to_lamp) / (reach * reach));
                gl_FragColor = vec4(pow(light / max(1.0, max(light.r, max(light.g, light.b))), vec3(1.0 / 2.2)), 1.0);
            }`,
    });
}

/// Gives what finds how far the surface is below a point of the canvas, in pixels; 0: there is none.
function distanceFinder(renderer, scene, camera, far) {
    const target = new THREE.WebGLRenderTarget(1, 1), pixel = new Uint8Array(4);
    const material = new THREE.ShaderMaterial({
        uniforms: { far: { value: far } },
        vertexShader: over_surface,
        fragmentShader: `
            uniform float far; varying vec3 place;
            void main() {
                vec3 parts = fract(min(length(place - cameraPosition) / far, 0.999) * vec3(1.0, 255.0, 65025.0));
                gl_FragColor = vec4(parts - vec3(parts.yz / 255.0, 0.0), 1.0);
            }`,
    });
    return (x, y) => {
        const { clientWidth, clientHeight } = renderer.domElement;
        camera.setViewOffset(clientWidth, clientHeight, x, y, 1, 1);
        scene.overrideMaterial = material;
        renderer.setClearColor(0);
        renderer.setRenderTarget(target);
        renderer.render(scene, camera);
        renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel);
        renderer.setRenderTarget(null);
        renderer.setClearColor(background);
        scene.overrideMaterial = null;
        camera.clearViewOffset();
        return far * (pixel[0] + pixel[1] / 255 + pixel[2] / 65025) / 255;
    };
}

/// The vertices, x, y, z, 0, u, v of 0..65535 each, and three of them per face, as sdk/docs/report.md describes `geometry`. A room may
/// have `values` and `corners` instead.
function unpacked(room) {
    const bytes = new Uint8Array(bytesOf(room.geometry));
    const values = new Uint16Array(6 * room.vertices), corners = new Uint32Array(3 * room.triangles);
    const places = [0, 1, 2, 4, 5];
    let at = 0, count = 0, before = 0;
    const number = () => {
        let value = 0;
        for (let shift = 0; ; shift += 7) {
            const byte = bytes[at++];
            value |= (byte & 127) << shift;
            if (byte < 128)
                return value;
        }
    };
    for (let corner = 0; corner < corners.length; ++corner) {
        const ago = number();
        const vertex = count - ago;
        if (ago === 0) {
            ++count;
            for (const place of places) {
                const difference = number();
                values[6 * vertex + place] = (corner ? values[6 * before + place] : 0) + (difference >>> 1 ^ -(difference & 1));
            }
        }
        before = corners[corner] = vertex;
    }
    return { values, corners };
}

/// Vertices and texcoords of unpacked values.
function shapeOf({ values, corners }) {
    const buffer = new THREE.InterleavedBuffer(values, 6);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.InterleavedBufferAttribute(buffer, 3, 0, true));
    geometry.setAttribute("uv", new THREE.InterleavedBufferAttribute(buffer, 2, 4, true));
    geometry.setIndex(new THREE.BufferAttribute(corners, 1));
    return geometry;
}

async function meshOf(room, { mixture, relief }, anisotropy) {
    const { values, corners } = room.values ? room : unpacked(room);
    const material = mixture ? await mixingMaterial(mixture, anisotropy) : relief ? await litMaterial(room, relief, anisotropy) : new THREE.MeshBasicMaterial({ map: await textureOf(room.texture, anisotropy) });
    const mesh = new THREE.Mesh(shapeOf({ values, corners }), material);
    mesh.position.fromArray(room.low);
    mesh.scale.fromArray(room.extent.map(size => Math.max(size, 1e-9)));
    mesh.frustumCulled = false;  // Its bounds are unknown to three.js, which reads the packed numbers as they are.
    return { mesh, values, corners };
}

/// The room along east, north and up: `axes`, vectors of the world; and what planOf and floorOf look at.
function groundOf(room, { values, corners }, upwards) {
    const up = upwards.clone().normalize();
    const east = (Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0)).projectOnPlane(up).normalize();
    const axes = [east, up.clone().cross(east), up];
    const points = new Float32Array(3 * room.vertices);
    const ends = axes.map(() => [Infinity, -Infinity]);
    for (let i = 0; i < room.vertices; ++i) {
        const world = new THREE.Vector3().fromArray([0, 1, 2].map(axis => room.low[axis] + room.extent[axis] * values[6 * i + axis] / 65535));
        axes.forEach((axis, part) => {
            const along = points[3 * i + part] = world.dot(axis);
            ends[part] = [Math.min(ends[part][0], along), Math.max(ends[part][1], along)];
        });
    }
    const [a, b, c] = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
    const take = (corner, i) => {
        for (let part = 0; part < 3; ++part)
            corner[part] = points[3 * corners[i] + part];
    };
    const triangles = visit => {
        for (let i = 0; i < corners.length; i += 3) {
            take(a, i);
            take(b, i + 1);
            take(c, i + 2);
            visit(a, b, c);
        }
    };
    return { axes, triangles, ends };
}

/// The value below which a share of the numbers lies.
const quantile = (numbers, share) => numbers.sort((a, b) => a - b)[Math.floor(share * (numbers.length - 1))];

/// Some of the vertices, and the middle of most: without the crumbs far off, which would push the room aside.
function sampleOf(room, values) {
    const step = Math.max(1, Math.floor(room.vertices / 20000));
    const points = [];
    for (let i = 0; i < room.vertices; i += step)
        points.push(vector([0, 1, 2].map(axis => room.low[axis] + room.extent[axis] * values[6 * i + axis] / 65535)));
    const middle = vector(["x", "y", "z"].map(axis => {
        const along = points.map(point => point[axis]);
        return (quantile(along, 0.02) + quantile(along, 0.98)) / 2;
    }));
    return { points, middle };
}

const hints = {
    walk: ["Drag: look · W A S D or arrows: walk · wheel: step", "One finger: look · two fingers: walk"],
    light: ["Drag: move the lamp along the surface", "One finger: move the lamp along the surface"],
    orbit: ["Drag: turn · right button: move · wheel: zoom", "One finger: turn · two fingers: move, zoom"],
};

/// Fills the box. Gives {walk, orbit, light, standAt, mix, position}, pose, draw and dispose for pages that show one room after the other, and for a headset {renderer, scene, camera, ground, worldOf, here, resize}: walk() begins where the recorder stood, or else in the widest place; standAt
/// begins at a pose. Both stay inside. light() lets the pointer move the lamp, or no longer; it is missing without a relief. `mixture`: what texture.mix shows; `relief`: what
/// texture.relief shows, but not together with a mixture; `cameras`: where the recorder stood, {position, forward, up, looking};
/// `up`: what a stage found. Each of them may be missing.
async function showRoom(place, room, { mixture, relief, cameras, up } = {}) {
    if (!document.createElement("canvas").getContext("webgl"))
        throw new Error("this browser has no WebGL. Switch on its hardware acceleration, or use another one.");
    const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    renderer.setClearColor(background);
    const packed = await meshOf(room, { mixture, relief }, renderer.capabilities.getMaxAnisotropy());
    const scene = new THREE.Scene();
    scene.add(packed.mesh);
    const reach = vector(room.extent).length();
    const camera = new THREE.PerspectiveCamera(60, 1, reach / 2000, reach * 10);
    const upwards = vector(up ?? cameras?.up ?? [0, 0, 1]);
    camera.up.copy(upwards);
    const canvas = renderer.domElement;
    const controls = new THREE.OrbitControls(camera, canvas);
    controls.screenSpacePanning = true;
    controls.maxDistance = 4 * reach;
    const hint = document.createElement("p");
    hint.className = "hint";
    const draw = () => renderer.render(scene, camera);
    const begin = mode => {
        controls.enabled = mode === "orbit";
        place.dataset.mode = mode;
        hint.textContent = hints[mode][matchMedia("(pointer: coarse)").matches ? 1 : 0];
    };

    // Backs of faces are not drawn: from above and outside one looks in, from behind where the cameras were.
    const sample = sampleOf(room, packed.values);
    const orbit = () => {
        const from = direction => vector(direction).addScaledVector(upwards, -vector(direction).dot(upwards));
        let side = from((cameras?.looking ?? [0, 0, 0]).map(part => -part));
        if (side.length() < 0.05)
            side = from([0.6, 0.35, 0.72]);
        side.normalize().addScaledVector(upwards, 0.9).normalize();
        begin("orbit");
        const right = upwards.clone().cross(side).normalize(), top = side.clone().cross(right);
        const high = Math.tan(camera.fov * Math.PI / 360), wide = high * camera.aspect;  // Of half the view, at a meter.
        const distances = sample.points.map(point => {
            const from_middle = point.clone().sub(sample.middle);
            return from_middle.dot(side) + Math.max(Math.abs(from_middle.dot(right)) / wide, Math.abs(from_middle.dot(top)) / high);
        });
        camera.position.copy(sample.middle).addScaledVector(side, 1.05 * quantile(distances, 0.98));
        controls.target.copy(sample.middle);
        controls.update();
        draw();
    };

    // The walker: east, north and up in meters, and where the eye looks.
    const ground = groundOf(room, packed, upwards);
    let eye = [0, 0, 0], yaw = 0, pitch = 0, plan = null, plan_height = null;
    const planHere = () => {
        if (plan_height === null || Math.abs(plan_height - eye[2]) > 0.1) {
            plan_height = eye[2];
            plan = planOf(ground.triangles, ground.ends.slice(0, 2).map(([low]) => low), ground.ends.slice(0, 2).map(([, high]) => high), plan_height);
        }
        return plan;
    };
    const worldOf = parts => ground.axes.reduce((sum, axis, i) => sum.addScaledVector(axis, parts[i]), new THREE.Vector3());
    const look = () => {
        camera.position.copy(worldOf(eye));
        camera.lookAt(camera.position.clone().add(worldOf([Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)])));
        draw();
    };
    const stand = (at, forward, steepest) => {
        eye = at;
        const [east, north, upward] = ground.axes.map(axis => forward.dot(axis));
        yaw = Math.atan2(north, east);
        pitch = Math.max(-steepest, Math.min(steepest, Math.atan2(upward, Math.hypot(east, north))));
        begin("walk");
        look();
    };
    const standAt = (pose, steepest = 1.4) => stand(ground.axes.map(axis => vector(pose.position).dot(axis)), vector(pose.forward), steepest);
    const walk = () => {
        if (cameras)
            return standAt(cameras, 0.3);
        const [floor, ceiling] = [floorOf(ground.triangles, ...ground.ends[2]), ground.ends[2][1]];
        eye = [0, 0, Math.min(floor + 1.6, (floor + ceiling) / 2 + 0.3)];
        const found = widestPlace(planHere());
        if (!found)
            return orbit();
        stand([...found.place, eye[2]], worldOf([Math.cos(found.angle), Math.sin(found.angle), -0.12]), 0.3);
    };
    walkingControls(canvas, {
        enabled: () => place.dataset.mode === "walk",
        turn: (dx, dy) => {
            const radians = camera.fov * Math.PI / 180 / canvas.clientHeight;
            yaw += dx * radians;
            pitch = Math.max(-1.4, Math.min(1.4, pitch + dy * radians));
            look();
        },
        walk: (ahead, aside) => {
            const way = [ahead * Math.cos(yaw) + aside * Math.sin(yaw), ahead * Math.sin(yaw) - aside * Math.cos(yaw)];
            const steps = Math.ceil(Math.hypot(...way) / (0.5 * cell_m));
            for (let i = 0; i < steps; ++i)
                [eye[0], eye[1]] = stepFrom(planHere(), eye, way.map(part => part / steps));
            look();
        },
    });

    const lamp = mixture || !relief ? null : packed.mesh.material.uniforms;
    let light;
    if (lamp) {
        lamp.lamp.value.copy(sample.middle).addScaledVector(upwards, 0.2 * (ground.ends[2][1] - ground.ends[2][0]));
        lamp.reach.value = 0.6 * reach;
        const distanceAt = distanceFinder(renderer, scene, camera, camera.far);
        const moveTo = event => {
            const { left, top, width, height } = canvas.getBoundingClientRect(), [x, y] = [event.clientX - left, event.clientY - top];
            const distance = distanceAt(x, y);
            if (distance > 0) {
                const ahead = new THREE.Vector3(2 * x / width - 1, 1 - 2 * y / height, 0.5).unproject(camera).sub(camera.position).normalize();
                lamp.lamp.value.copy(camera.position).addScaledVector(ahead, 0.85 * distance);
                lamp.reach.value = distance;
            }
            draw();
        };
        for (const name of ["pointerdown", "pointermove"])
            canvas.addEventListener(name, event => place.dataset.mode === "light" && event.buttons && moveTo(event));
        let before = "walk";
        light = () => {
            if (place.dataset.mode !== "light")
                before = place.dataset.mode;
            begin(place.dataset.mode === "light" ? before : "light");
        };
    }
    const mix = (name, share) => {
        packed.mesh.material.uniforms[name].value = share;
        draw();
    };
    const resize = () => {
        const { width, height } = place.getBoundingClientRect();
        renderer.setSize(width, height, false);
        camera.aspect = width / Math.max(height, 1);
        // Upright screens see more above and below, so that they see enough beside.
        camera.fov = 360 / Math.PI * Math.atan(Math.tan(Math.PI / 6) * Math.max(1, Math.min(1.6, 1 / camera.aspect)));
        camera.updateProjectionMatrix();
        draw();
    };
    controls.addEventListener("change", draw);
    window.addEventListener("resize", resize);
    place.prepend(canvas, hint);
    canvas.tabIndex = 0;
    resize();
    walk();
    place.dataset.ready = "yes";
    const here = () => {
        const [east, north] = ground.axes.map(axis => camera.position.dot(axis));
        return { east, north, yaw };
    };
    const pose = () => ({ position: camera.position.toArray(), forward: camera.getWorldDirection(new THREE.Vector3()).toArray() });
    const dispose = () => {
        window.removeEventListener("resize", resize);
        controls.dispose();
        packed.mesh.geometry.dispose();
        renderer.forceContextLoss();
        renderer.dispose();
        canvas.remove();
        hint.remove();
    };
    return { walk, orbit, light, standAt, mix, draw, pose, dispose, position: () => camera.position.toArray(), renderer, scene, camera, ground, worldOf, here, resize };
}
