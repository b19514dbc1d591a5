"""Pictures of `propmap explore` for the documentation: ``python -m tools.explore_pictures``."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

from tools.explore_browser import browser, explorer, open_view, settle

FOLDER = Path(__file__).parents[1] / "docs" / "figures"

SIZE = {"width": 1200, "height": 760}

PICTURES = {
    "explore-loads": "/loads?prop=apc-8x6e&rpm=5170&speed=8&beta=60",
    "explore-disk": "/disk?prop=apc-8x6e&rpm=5170&speed=14&beta=80",
    "explore-blade": "/blade?prop=apc-8x6e&rpm=5170&chord-3=130&twist-4=3",
    "explore-constants": "/constants?prop=apc-8x6e&data=uiuc-8x6e&c_l1=5.5",
    "explore-compare": "/compare?prop=apc-8x6e&a=apc-8x6e&b=apc-8x4.5mr&equal=thrust",
}
"""Where each picture is taken: its file, and the address."""

COLORS = 160
"""Colors of the pictures: few, so that they are small."""


def main() -> None:
    """Take them all."""
    with explorer("apc-8x6e") as (address, _), browser() as one:
        page = one.new_page(viewport=SIZE)  # type: ignore[arg-type]
        for name, place in PICTURES.items():
            open_view(page, address + place, 180.0)
            settle(page, 180.0)
            page.wait_for_timeout(500.0)
            path = FOLDER / f"{name}.png"
            page.screenshot(path=path)
            with Image.open(path) as picture:
                few = picture.convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
            few.save(path, optimize=True)
            print(f"wrote {path} ({path.stat().st_size / 1e3:.0f} kB)")


if __name__ == "__main__":
    main()
