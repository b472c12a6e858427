"use strict";
(() => {
    const data = JSON.parse(document.getElementById("report-data").textContent);

    // Camera picture and render, one over the other, cut where the slider stands.
    const compare = document.querySelector(".compare");
    if (compare) {
        const slider = compare.querySelector("input");
        const [under, over] = compare.querySelectorAll("img");
        const caption = document.getElementById("view-name");
        const thumbs = Array.from(document.querySelectorAll(".thumbs button"));
        const cut = () => compare.style.setProperty("--cut", `${slider.value}%`);
        const choose = number => {
            under.src = data.views[number].camera;
            over.src = data.views[number].render;
            caption.textContent = data.views[number].name;
            thumbs.forEach((thumb, other) => thumb.setAttribute("aria-pressed", other === number));
            compare.dataset.view = number;
        };
        slider.addEventListener("input", cut);
        thumbs.forEach((thumb, number) => {
            thumb.querySelector("img").src = data.views[number].render;
            thumb.addEventListener("click", () => choose(number));
        });
        choose(0);
        cut();
    }

    const box = document.getElementById("room");
    if (box)
        showRoom(box).catch(error => {
            box.textContent = "";
            const text = document.createElement("p");
            text.className = "soft";
            text.textContent = `The room cannot be shown here: ${error.message}`;
            box.append(text);
        });

    function bytes(base64) {
        const text = atob(base64);
        const result = new Uint8Array(text.length);
        for (let i = 0; i < text.length; ++i)
            result[i] = text.charCodeAt(i);
        return result.buffer;
    }

    async function showRoom(box) {
        const room = data.room;
        if (!document.createElement("canvas").getContext("webgl"))
            throw new Error("this browser has no WebGL.");
        const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
        renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
        renderer.setClearColor(0x20242a);
        const packed = bytes(document.getElementById("room-geometry").textContent.trim());
        const values = new THREE.InterleavedBuffer(new Uint16Array(packed, 0, 6 * room.vertices), 6);
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute("position", new THREE.InterleavedBufferAttribute(values, 3, 0, true));
        geometry.setAttribute("uv", new THREE.InterleavedBufferAttribute(values, 2, 4, true));
        geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(packed, 12 * room.vertices, 3 * room.triangles), 1));
        const picture = new Image();
        picture.src = document.getElementById("room-texture").textContent.trim();
        await picture.decode();
        const texture = new THREE.Texture(picture);
        texture.anisotropy = renderer.capabilities.getMaxAnisotropy();
        texture.needsUpdate = true;
        const mesh = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ map: texture }));
        mesh.position.fromArray(room.low);
        mesh.scale.fromArray(room.extent.map(size => Math.max(size, 1e-9)));
        mesh.frustumCulled = false;  // Its bounds are unknown to three.js, which reads the packed numbers as they are.
        const scene = new THREE.Scene();
        scene.add(mesh);

        const reach = new THREE.Vector3().fromArray(room.extent).length();
        const camera = new THREE.PerspectiveCamera(60, 1, reach / 2000, reach * 10);
        const upwards = room.start ? new THREE.Vector3().fromArray(room.start.up) : new THREE.Vector3(0, 0, 1);
        camera.up.copy(upwards);
        const controls = new THREE.OrbitControls(camera, renderer.domElement);
        controls.screenSpacePanning = true;
        const draw = () => renderer.render(scene, camera);
        const place = (position, target) => {
            camera.position.copy(position);
            controls.target.copy(target);
            controls.update();
            draw();
        };
        const stand = pose => {
            const position = new THREE.Vector3().fromArray(pose.position);
            place(position, new THREE.Vector3().fromArray(pose.forward).multiplyScalar(Math.min(1.5, reach / 4)).add(position));
        };
        // What most of the vertices lie in: crumbs far off would make the room a spot in the middle.
        const core = (() => {
            const sample = [[], [], []];
            const step = Math.max(1, Math.floor(room.vertices / 20000));
            for (let i = 0; i < room.vertices; i += step)
                sample.forEach((axis, k) => axis.push(values.array[6 * i + k] / 65535));
            const ends = sample.map((axis, k) => {
                axis.sort((a, b) => a - b);
                return [0.02, 0.98].map(share => room.low[k] + room.extent[k] * axis[Math.floor(share * (axis.length - 1))]);
            });
            const [low, high] = [0, 1].map(end => new THREE.Vector3().fromArray(ends.map(axis => axis[end])));
            return { middle: low.clone().add(high).multiplyScalar(0.5), reach: high.distanceTo(low) };
        })();
        // Backs of faces are not drawn: from above and outside one looks in, from behind where the cameras were.
        const outside = () => {
            const side = room.start ? new THREE.Vector3().fromArray(room.start.looking).multiplyScalar(-1) : new THREE.Vector3(0.6, 0.35, 0.72);
            side.addScaledVector(upwards, -side.dot(upwards));
            if (side.length() < 0.05)
                side.set(0.6, 0.35, 0.72);
            side.normalize();
            side.addScaledVector(upwards, 0.9 - side.dot(upwards));
            place(core.middle.clone().addScaledVector(side.normalize(), core.reach), core.middle);
        };
        const resize = () => {
            const { width, height } = box.getBoundingClientRect();
            renderer.setSize(width, height, false);
            camera.aspect = width / Math.max(height, 1);
            camera.updateProjectionMatrix();
            draw();
        };
        controls.addEventListener("change", draw);
        window.addEventListener("resize", resize);
        box.prepend(renderer.domElement);
        renderer.domElement.tabIndex = 0;
        document.getElementById("outside").addEventListener("click", outside);
        const inside = document.getElementById("inside");
        inside.hidden = !room.start;
        inside.addEventListener("click", () => stand(room.start));
        const here = document.getElementById("stand-here");
        if (here)
            here.addEventListener("click", () => {
                stand(data.views[Number(document.querySelector(".compare").dataset.view)].pose);
                box.scrollIntoView({ block: "center" });
            });
        room.start ? stand(room.start) : outside();
        resize();
        box.dataset.ready = "yes";
    }
})();
