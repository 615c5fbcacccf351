"""Roles: the words by which a workload names what a platform has, whatever the platform calls it.

A component or link fills a role by its name (a processor named ``host``), or by the key ``roles`` of the platform. The
name of a role means one thing on a platform: nothing else may have it as its name.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from pydantic import Field

from codesign.ground.errors import Fault, choose_hint, clip
from codesign.ground.models import SpecModel
from codesign.inputs.document import Document, KeyPath
from codesign.inputs.fields import Name

FABRIC, HOST, LINK = "fabric", "host", "link"

ROLE_TYPES = {FABRIC: "fpga", HOST: "processor"}
"""The type of component that fills a role. The role ``link`` is filled by a link of any type."""

ROLES = (FABRIC, HOST, LINK)


class Roles(SpecModel):
    """The meaning of ``fabric``, ``host`` and ``link`` on a platform."""

    fabric: Name | None = Field(
        default=None, description="Component of type fpga. Without it, the platform has no fabric."
    )
    host: Name | None = Field(default=None, description="Component of type processor.")
    link: Name | None = Field(
        default=None, description="Link between host and fabric: it joins them, or a route between them takes it."
    )


def filled_roles(roles: Mapping[str, Any], components: Mapping[str, Any], links: Collection[str]) -> dict[str, str]:
    """The name of the component or link that fills each role: as ``roles`` says, else the one of the role's name."""
    by_name = {role: role for role in ROLES if role in (links if role == LINK else components)}
    return by_name | {role: name for role, name in roles.items() if isinstance(name, str)}


def role_faults(document: Document) -> list[Fault]:
    """Roles that nothing of the right type fills, and names of roles that mean something else."""
    tree = document.tree if isinstance(document.tree, dict) else {}
    roles, components, links = (tree.get(key, {}) for key in ("roles", "components", "links"))
    if not (isinstance(roles, dict) and isinstance(components, dict) and isinstance(links, dict)):
        return []
    faults = _ambiguous(document, roles, components, links)
    sound = {}
    for role, name in roles.items():
        if role not in ROLES or not isinstance(name, str):
            continue
        refusal = _refusal(role, name, components, links)
        if refusal is None:
            sound[role] = name
        else:
            faults.append(document.fault(("roles", role), *refusal))
    if faults or LINK not in roles or LINK not in sound:
        return faults
    return _off_the_route(document, filled_roles(sound, components, links), links)


def _refusal(role: str, name: str, components: Mapping[str, Any], links: Mapping[str, Any]) -> tuple[str, str] | None:
    """The reason for which a component or link cannot fill a role, and the remedy."""
    if role == LINK:
        if name in links:
            return None
        what = f"{clip(name)} is a component, and no link" if name in components else f"there is no link {clip(name)!r}"
        return what, choose_hint(clip(name, 60), links) if links else "leave the role out, or add the link under links:"
    wanted = ROLE_TYPES[role]
    fitting = [other for other, raw in components.items() if _type(raw) == wanted]
    hint = choose_hint(clip(name, 60), fitting) if fitting else f"leave the role out: the platform has no {wanted}"
    if name not in components:
        return f"there is no component {clip(name)!r}", hint
    kind = _type(components[name])
    if kind is None or kind == wanted:
        return None
    return f"the {role} is a component of type {wanted}, and {clip(name)} is of type {clip(kind, 60)}", hint


def _ambiguous(
    document: Document, roles: Mapping[str, Any], components: Mapping[str, Any], links: Mapping[str, Any]
) -> list[Fault]:
    """Components and links with the name of a role that they do not fill."""
    faults = []
    for section, entries in (("components", components), ("links", links)):
        for role in ROLES:
            if role not in entries or (section == "links" and role in components):
                continue  # A link with the name of a component has a fault of its own.
            kind = _type(entries[role])
            filler = roles.get(role)
            if (section == "links") != (role == LINK) or (role in ROLE_TYPES and kind not in {None, ROLE_TYPES[role]}):
                meant = "a link" if role == LINK else f"a component of type {ROLE_TYPES[role]}"
                what = f"{role} is the name of a role, which {meant} fills"
            elif isinstance(filler, str) and filler != role:
                what = f"{role} is the name of a role, which {clip(filler)} fills"
            else:
                continue
            faults.append(document.fault((section, role), what, "give it another name", at_key=True))
    return faults


def _type(raw: Any) -> str | None:
    kind = raw.get("type") if isinstance(raw, dict) else None
    return kind if isinstance(kind, str) else None


def _off_the_route(document: Document, filled: Mapping[str, str], links: Mapping[str, Any]) -> list[Fault]:
    """The link of a role that is not between host and fabric."""
    place: KeyPath = ("roles", LINK)
    missing = [role for role in ROLE_TYPES if role not in filled]
    if missing:
        what = f"the platform has no {' and no '.join(missing)}, so that nothing is linked"
        return [document.fault(place, what, f"fill the role {missing[0]} too, or leave link out")]
    ends = {
        name: [end for end in link["between"] if isinstance(end, str)]
        for name, link in links.items()
        if isinstance(link, dict) and isinstance(link.get("between"), list)
    }
    chosen, host, fabric = filled[LINK], filled[HOST], filled[FABRIC]
    others = [joined for name, joined in ends.items() if name != chosen]
    here, there = _reached(host, others), _reached(fabric, others)
    between = ends.get(chosen, [])
    if any(a in here and b in there and a != b for a in between for b in between):
        return []
    joining = [name for name, joined in ends.items() if {host, fabric} <= set(joined)]
    hint = f"name {' or '.join(joining)}" if joining else "name a link on the route between them, or leave link out"
    return [document.fault(place, f"no route between {host} and {fabric} takes link {clip(chosen)}", hint)]


def _reached(start: str, links: Collection[Collection[str]]) -> set[str]:
    """The components that links lead to from one of them, itself among them."""
    reached, size = {start}, 0
    while size < len(reached):
        size = len(reached)
        for ends in links:
            if not reached.isdisjoint(ends):
                reached.update(ends)
    return reached
