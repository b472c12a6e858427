// Begins: the room and where the cameras stood are in the page.

const { room, relief, cameras, up } = JSON.parse(document.getElementById("data").textContent);
const place = document.getElementById("room");
const buttons = new Map(["walk", "orbit", "light"].map(mode => [mode, document.getElementById(mode)]));
let shown = null;

const tell = () => buttons.forEach((button, mode) => button.setAttribute("aria-pressed", place.dataset.mode === mode));

showRoom(place, room, { relief, cameras, up }).then(viewer => {
    document.getElementById("loading").remove();
    shown = viewer;
    buttons.get("light").hidden = !shown.light;
    for (const [mode, button] of buttons)
        button.addEventListener("click", () => {
            shown[mode]();
            tell();
            place.querySelector("canvas").focus();
        });
    tell();
    place.querySelector("canvas").focus();
    offerVr(document.getElementById("vr"), shown, text => { place.querySelector(".hint").textContent = text; });
}).catch(error => {
    const message = document.createElement("p");
    message.className = "message";
    message.textContent = `The room cannot be shown: ${error.message}`;
    document.querySelector("nav").remove();
    place.replaceChildren(message);
});
