"""fit_text.py: the record of a fit as text: choice, leave-one-out, lobes, integrals, symmetry, reciprocity."""

from typing import Any

from gonio.model.analytic.as_text import component_lines

_CONTRADICTED = "CONTRADICTED by the data"


def text(record: dict[str, Any]) -> str:
    """Lines for provenance["model"], of lobes or of an analytic family."""
    lines = [f"symmetry {record['symmetry']} (declared)"]
    analytic = record.get("kind") == "analytic"
    for channel, found in record["channels"].items():
        components = found["components"] if analytic else found
        for name, component in components.items():
            lines += ["", f"{channel}, {name}"]
            lines += component_lines(component) if analytic else _lobes(component)
    return "\n".join(lines)


def _lobes(component: dict[str, Any]) -> list[str]:
    lines = [f"  interpolation {component['chosen']}, by {component['by']}"]
    table = component["leave_one_out"]
    if table:
        directions = len(table[0]["left_out"])
        lines.append(f"  leave-one-out over {directions} incident direction{'s' if directions > 1 else ''}:")
        lines.append(f"    {'method':22} {'hellinger':>10} {'CV(RMSD)':>9} {'within 10 %':>12}")
        for row in table:
            chosen = " <" if row["method"] == component["chosen"] else ""
            lines.append(
                f"    {row['method']:22} {row['hellinger']:10.2e} {row['cv_rmsd']:9.4f} "
                f"{row['within_10_percent']:10.1f} %{chosen}"
            )
    lines.append(
        "  theta_i  phi_i   points  integral: points    model    scale  lobes: theta,phi peak [1/sr] sigma [deg]"
    )
    for node in component["nodes"]:
        lobes = "; ".join(
            f"{lobe['theta_deg']:.2f},{lobe['phi_deg'] % 359.995:.1f} {lobe['peak_per_sr']:.4g} "
            f"{lobe['sigma_deg'][0]:.3g} x {lobe['sigma_deg'][1]:.3g}{' *' if lobe['carried_over'] else ''}"
            for lobe in node["lobes"]
        )
        lines.append(
            f"  {node['theta_deg']:7.2f} {node['phi_deg']:6.1f} {node['points']:8d} {node['integral_points']:16.4f} "
            f"{node['integral_model']:8.4f} {node['scale']:8.4f}  {lobes or 'none'}"
        )
    if any(lobe["carried_over"] for node in component["nodes"] for lobe in node["lobes"]):
        lines.append("  * no point sees its top there: carried over from the neighbouring incident directions")
    if component["least_bound"] is not None and component["least_bound"] < 1.0:
        lines.append(f"  between directions scaled to their integrals: by {component['least_bound']:.4f} at most")
    for test in component["symmetry_test"]:
        verdict = _CONTRADICTED if test["contradicted"] else "agrees"
        lines.append(
            f"  symmetry, {test['image']}: {verdict}: {test['pairs']} pairs differ by {test['rms_u']:.2f} u (rms), "
            f"{100.0 * test['share']:.1f} % of the light"
        )
    if not component["symmetry_test"]:
        lines.append("  symmetry: no directions to test it with")
    for key, words in (("reciprocity", "reciprocity"), ("reciprocity_enforced", "reciprocity, once enforced")):
        if key in component:
            found = component[key]
            lines.append(
                f"  {words}: residual {100.0 * found['relative_rms']:.2f} % rms, {found['rms_u']:.2f} u "
                f"({found['pairs']} pairs)"
            )
    return lines + [f"  finding: {finding}" for finding in component["findings"]]


def warnings(record: dict[str, Any]) -> list[str]:
    """One line for each contradicted symmetry and each finding."""
    if record.get("kind") == "analytic":
        return [
            f"{channel}: {finding}" for channel, entry in record["channels"].items() for finding in entry["findings"]
        ] + [
            f"{channel}, {name}: {finding}"
            for channel, entry in record["channels"].items()
            for name, component in entry["components"].items()
            for finding in component.get("findings", [])
        ]
    found = []
    for channel, components in record["channels"].items():
        for name, component in components.items():
            found += [
                f"{channel}, {name}: symmetry {record['symmetry']} is contradicted: {test['image']}, {test['pairs']} "
                f"pairs differ by {test['rms_u']:.2f} u (rms), {100.0 * test['share']:.1f} % of the light"
                for test in component["symmetry_test"]
                if test["contradicted"]
            ]
            found += [f"{channel}, {name}: {finding}" for finding in component["findings"]]
    return found
