"""The tree of arbiters that chooses the next line (Boahen, IEEE TCAS-II 47(5), 2000).

A node of the tree chooses between its two sides. The side that requested first wins; if both
requested at once, either may win. When the winner is done, the other side follows if it waits.
Then the node hands the grant up, and requests it anew if something waits by then. A grant thus
visits neighbours before it goes far ("greedy"), but no side is served twice in a visit, so that
every line gets its turn.

A recording of a DAVIS346 whose bus is busy all the time shows these rules. Of 19,844 visits to
blocks of 2 to 32 columns that are aligned as in such a tree, 5830 served both halves one after the
other, and 4 returned to the first half. If the blocks are shifted by half their size, only 1722 of
23,953 visits serve both halves. docs/explanation/readout.md names the recording.

The nodes are numbered as in a heap: 1 is the root, 2n and 2n + 1 are the sides of node n, and line
l is the leaf `leaves + l`. Level 0 are the leaves. A node that is being visited keeps its request.
"""

from __future__ import annotations

import numpy as np

from emulator.readout.arbiter_queue import LAST_LINE, NONE, SECOND, Longs
from flybench.kernels import compiled

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX = np.uint64(0xBF58476D1CE4E5B9)
_S27, _S63 = np.uint64(27), np.uint64(63)


@compiled
def request_line(tree: Longs, line: int, at_ps: int) -> None:
    """Pass the request of a line on, up to the first node that requests already."""
    node = (tree.size >> 1) + line
    while node > 0 and tree[node] == NONE:
        tree[node] = at_ps
        node >>= 1


@compiled
def next_in_tree(tree: Longs, marks: Longs, now_ps: int) -> int:
    """Return the line that gets the grant; there must be a request."""
    node: int = hand_up(tree, marks, now_ps)
    leaves = tree.size >> 1
    while node < leaves:
        left, right = tree[2 * node], tree[2 * node + 1]
        if left == NONE or right == NONE:
            node = 2 * node + (left == NONE)
        elif left == right:
            node = 2 * node + either(node, now_ps)
        else:
            node = 2 * node + (right < left)
    return node - leaves


@compiled
def hand_up(tree: Longs, marks: Longs, now_ps: int) -> int:
    """Hand the grant up from the line granted last, and return the node that gets it next.

    Args:
        tree: request time of each node; changed in place [ps].
        marks: line granted last, and levels at which it is on the second side; changed in place.
        now_ps: time at which that line is done [ps].

    Returns:
        The first sibling on the way up that waits for its turn; otherwise the root.
    """
    if marks[LAST_LINE] == NONE:
        return 1
    level = np.int64(1)
    node: int = (tree.size >> 1) + marks[LAST_LINE]
    while node > 1:
        waits = tree[node ^ 1] != NONE
        if waits and marks[SECOND] & level == 0:
            marks[SECOND] |= level
            return node ^ 1
        marks[SECOND] &= ~level
        tree[node >> 1] = now_ps if waits or tree[node] != NONE else NONE
        node >>= 1
        level *= 2
    return 1


@compiled
def either(node: int, now_ps: int) -> int:
    """Choose a side without preference: 0 or 1, by a hash of node and time (assumed)."""
    z = (np.uint64(now_ps) + np.uint64(node)) * _GOLDEN
    z = (z ^ (z >> _S27)) * _MIX
    return int((z ^ (z >> _S27)) >> _S63)
