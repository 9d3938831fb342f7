"""A robot driven through two tags in the open, several times."""

import octant

tags = [octant.Tag("0xFFF9", (2.0, 0.5, 2.0)), octant.Tag("0xFFF2", (3.5, 2.0, 2.0))]
reader = octant.Reader(response="rays")
room = octant.Room.free_space()
runs = octant.Mission(room, tags, reader, start=(0.0, 0.0, 90.0), navigator="tracker").run(5)
print(runs, *runs.lines(), sep="\n")
runs.animate(0).save("run.gif")
