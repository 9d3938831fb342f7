"""One edge: exact solutions, continuity across every boundary, reciprocity."""

import numpy as np
import pytest
from exact_wedges import (
    HARD,
    SOFT,
    geometrical_optics,
    line_source,
    plane_wave_half_plane,
    point_source,
    point_source_diffracted,
)
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.special import hankel2, wofz

from octant.em.fields._diffraction_kernels import diffract
from octant.em.medium._reflection_kernels import half_space, slab
from octant.em.medium.wedges import (
    CONDUCTOR,
    WedgeFaces,
    transition_function,
    wedge_coefficients,
)
from octant.geometries.errors import GeometryError

K = 2.0 * np.pi  # one wavelength is one metre
KINDS = ((SOFT, 0), (HARD, 1))
MATERIALS = (CONDUCTOR, 5.24 - 0.33j, 2.58 - 0.09j, 6.31 - 0.1j, 1.99 - 0.05j)


def decibel(x):
    return 20.0 * np.log10(np.abs(x))


# Transition function


def test_transition_function_is_the_faddeeva_function():
    x = np.concatenate([np.logspace(-16.0, 14.0, 3001), np.linspace(50.0, 150.0, 501)])
    turn = np.exp(0.25j * np.pi)
    exact = np.sqrt(np.pi * x) * turn * wofz(1j * turn * np.sqrt(x))
    assert np.max(np.abs(transition_function(x) / exact - 1.0)) < 1e-13
    assert transition_function(0.0) == 0.0


def test_transition_function_equals_the_printed_values():
    printed = [0.5717 + 0.2730j, 0.6768 + 0.2682j, 0.8095 + 0.2322j, 0.9472 + 0.1326j]
    assert transition_function([0.3, 0.5, 1.0, 3.0]) == pytest.approx(printed, abs=6e-5)


# Perfect conductors against exact solutions


@pytest.mark.parametrize(("kind", "i"), KINDS)
@pytest.mark.parametrize("rho_m", [0.2, 1.0, 50.0, 1000.0])
def test_plane_wave_on_a_half_plane_is_sommerfelds(rho_m, kind, i):
    phi = np.linspace(0.0, 2.0 * np.pi, 181)
    for phi_in in np.radians([1.0, 45.0, 90.0, 160.0, 250.0]):
        d = wedge_coefficients(
            phi_in,
            phi,
            air_angle_rad=2.0 * np.pi,
            wavenumber_rad_per_m=K,
            before_m=np.inf,
            after_m=rho_m,
        )[:, i, i]
        go = np.zeros(len(phi), complex)
        for beta, weight, rim in ((phi - phi_in, 1.0, 1e-9), (phi + phi_in, kind, -1e-9)):
            lit = np.cos(beta / 2.0) > rim  # a ray that touches is hidden, a reflection is there
            go += weight * lit * np.exp(1j * K * rho_m * np.cos(beta))
        total = go + d * np.exp(-1j * K * rho_m) / np.sqrt(rho_m)
        exact = plane_wave_half_plane(K, rho_m, phi, phi_in, kind)
        assert np.max(np.abs(total - exact)) < 1e-9


def test_the_shadow_boundary_of_a_half_plane_has_half_the_incident_field():
    d = wedge_coefficients(
        1.0,
        1.0 + np.pi,
        air_angle_rad=2.0 * np.pi,
        wavenumber_rad_per_m=1e6 * K,
        before_m=3.0,
        after_m=2.0,
    )
    total = np.diag(d) * np.sqrt(5.0 / 6.0)  # a ray that touches the edge is hidden
    assert total == pytest.approx([0.5, 0.5], abs=1e-3)


def sampled(n):
    for phi_in in np.array([0.07, 0.313, 0.627]) * n * np.pi:
        for phi in np.linspace(0.02, 0.98, 13) * n * np.pi:
            yield phi_in, phi


def errors(n, before_m, after_m, kind, i):
    """Total field of a point source: error over the free-space field, and in dB."""
    relative, db = [], []
    for phi_in, phi in sampled(n):
        ends = (before_m, phi_in, 0.0), (after_m, phi, 0.0)
        d = wedge_coefficients(
            phi_in,
            phi,
            air_angle_rad=n * np.pi,
            wavenumber_rad_per_m=K,
            before_m=before_m,
            after_m=after_m,
        )[i, i]
        go = geometrical_optics(lambda r: np.exp(-1j * K * r) / r, n, *ends, kind)
        length = before_m + after_m
        total = go + d * np.exp(-1j * K * length) / np.sqrt(before_m * after_m * length)
        exact = point_source(K, n, *ends, kind)
        relative.append(abs(total - exact) * length)
        db.append(abs(decibel(total) - decibel(exact)) if abs(exact) * length > 0.3 else 0.0)
    return max(relative), max(db)


@pytest.mark.parametrize(("kind", "i"), KINDS)
@pytest.mark.parametrize("n", [2.0, 1.75, 1.5, 1.25, 0.7])
@pytest.mark.parametrize(
    ("before_m", "after_m", "tolerance"), [(1.0, 1.1, 8e-3), (1.0, 5.0, 3e-3), (5.0, 6.0, 3e-4)]
)
def test_point_sources_beyond_a_wavelength_are_exact_to_a_tenth_of_a_decibel(
    n, before_m, after_m, tolerance, kind, i
):
    relative, db = errors(n, before_m, after_m, kind, i)
    assert relative < tolerance
    assert db < 0.1


@pytest.mark.parametrize(("kind", "i"), KINDS)
@pytest.mark.parametrize("n", [2.0, 1.75, 1.5, 1.25])
@pytest.mark.parametrize(
    ("apart_m", "tolerance"), [(0.5, 0.012), (0.25, 0.035), (0.1, 0.12), (0.01, 0.5)]
)
def test_nearer_than_a_wavelength_the_error_grows_slowly(n, apart_m, tolerance, kind, i):
    relative, _ = errors(n, apart_m, apart_m, kind, i)
    assert relative < tolerance


@pytest.mark.parametrize(("kind", "i"), KINDS)
@pytest.mark.parametrize("n", [2.0, 1.5, 1.25])
def test_line_sources_agree_with_the_eigenfunction_series(n, kind, i):
    far = np.sqrt(2j / (np.pi * K))  # H0(2)(kr) ~ far e^{-jkr} / sqrt(r)
    for phi_in, phi in sampled(n):
        near_end, far_end = (8.0, phi_in), (9.0, phi)
        d = wedge_coefficients(
            phi_in,
            phi,
            air_angle_rad=n * np.pi,
            wavenumber_rad_per_m=K,
            before_m=8.0,
            after_m=9.0,
        )[i, i]
        go = geometrical_optics(
            lambda r: hankel2(0, K * r), n, (*near_end, 0.0), (*far_end, 0.0), kind
        )
        total = go + far * d * np.exp(-17j * K) / np.sqrt(72.0)
        exact = line_source(K, n, near_end, far_end, kind)
        assert abs(total - exact) < 1.5e-3 * abs(far) / np.sqrt(17.0)


def test_the_two_exact_solutions_agree():
    """A line source is a row of point sources: the series and the integral check each other."""
    ends, n, turn = ((1.0, 0.4), (1.5, 3.9)), 1.5, np.exp(-0.25j * np.pi)
    u, du = np.polynomial.legendre.leggauss(120)
    row = [
        point_source_diffracted(K, n, (*ends[0], 0.0), (*ends[1], 6.0 * turn * z), HARD) for z in u
    ]
    series = line_source(K, n, *ends, HARD)
    go = geometrical_optics(lambda r: hankel2(0, K * r), n, (*ends[0], 0.0), (*ends[1], 0.0), HARD)
    assert go + 6.0 * turn * np.dot(row, du) / (-1j * np.pi) == pytest.approx(series, abs=1e-6)


@pytest.mark.parametrize("m", [1, 2, 3, 4])
def test_conducting_corners_that_divide_a_half_turn_do_not_diffract(m):
    phi = np.linspace(0.0, np.pi / m, 31)
    d = wedge_coefficients(
        phi[:, None],
        phi,
        air_angle_rad=np.pi / m,
        wavenumber_rad_per_m=K,
        before_m=1.0,
        after_m=2.0,
    )
    assert not d.any()


def test_a_flat_seam_of_one_lossy_material_does_not_diffract():
    faces = WedgeFaces(permittivity=(5.24 - 0.33j, 5.24 - 0.33j))
    d = wedge_coefficients(
        np.linspace(0.1, 3.0, 9)[:, None],
        np.linspace(0.1, 3.0, 8),
        air_angle_rad=np.pi,
        wavenumber_rad_per_m=K,
        before_m=1.0,
        after_m=2.0,
        skew_rad=0.8,
        faces=faces,
    )
    assert np.max(np.abs(d)) < 1e-5


# A source in a conducting 90 degree corner, on the bisector: line source over free space, seen from
# far away at 0 and 30 degrees from the bisector.
CORNER = {0.25: (2.0, 0.99642), 0.5: (4.0, 1.82545), 0.75: (2.0, 0.23376), 1.0: (0.0, 3.33226)}


@pytest.mark.parametrize("place_m", CORNER)
def test_corner_reflector_is_its_images(place_m):
    for degrees, ratio in zip((0.0, 30.0), CORNER[place_m], strict=True):
        phi = np.radians(45.0 + degrees)
        far = 1e7
        d = wedge_coefficients(
            np.pi / 4.0,
            phi,
            air_angle_rad=np.pi / 2.0,
            wavenumber_rad_per_m=K,
            before_m=place_m,
            after_m=far,
        )[0, 0]
        go = geometrical_optics(
            lambda r: np.exp(-1j * K * (r - 1e7)),
            0.5,
            (place_m, np.pi / 4.0, 0.0),
            (far, phi, 0.0),
            SOFT,
        )
        total = go + d * np.exp(-1j * K * place_m) / np.sqrt(place_m)
        assert abs(total) == pytest.approx(ratio, abs=1e-5)


# Vector fields


def make_frame(n, rng):
    """Return a random edge frame: the row for the kernels and the axis."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    t0, n0 = q[0], q[1]
    return np.array([[*t0, *n0, n]]), np.cross(t0, n0)


def ray(frame, axis, phi, beta, outward):
    """Unit direction of travel of a ray at azimuth phi, away from the edge or towards it."""
    across = np.cos(phi) * frame[0, :3] + np.sin(phi) * frame[0, 3:6]
    return np.cos(beta) * axis + (1.0 if outward else -1.0) * np.sin(beta) * across


def at_edge(frame, faces, before_m, after_m, incoming, outgoing, field, tolerance_m=1e-12):
    return np.array(
        diffract(
            np.pad(frame, ((0, 0), (0, 6))),  # an edge without ends
            *faces.kernel_arrays(),
            0,
            K,
            tolerance_m,
            0.0,
            before_m,
            after_m,
            *incoming,
            *outgoing,
            *field.astype(complex),
        )
    )


def dipole_field(place, at, moment, electric):
    """Far field e^{-jkr}/r of an electric or magnetic dipole."""
    r = np.linalg.norm(at - place)
    d = (at - place) / r
    e = moment - d * (d @ moment) if electric else np.cross(moment, d)
    return e * np.exp(-1j * K * r) / r


@pytest.mark.parametrize("electric", [True, False])
def test_dipoles_along_the_edge_are_exact_at_oblique_incidence(electric):
    """E of a Hertz potential along the edge: it solves the wedge with one scalar alone."""
    n, kind, step = 1.5, SOFT if electric else HARD, 1e-3
    frame, axis = np.array([[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, n]]), np.array([0.0, 0.0, 1.0])
    r0, r1, z1 = 40.0, 50.0, 60.0
    for phi_in, phi in ((0.6, 4.2), (2.0, 3.0), (0.6, 2.4)):

        def potential(x, y, z, phi_in=phi_in):
            azimuth = np.arctan2(y, x) % (2.0 * np.pi)
            ends = (r0, phi_in, 0.0), (np.hypot(x, y), azimuth, z)
            return point_source_diffracted(K, n, *ends, kind)

        at = np.array([r1 * np.cos(phi), r1 * np.sin(phi), z1])
        gradient_z = [
            (
                potential(
                    *(at + step * e),
                )
                - potential(*(at - step * e))
            )
            / (2.0 * step)
            for e in np.eye(3)
        ]
        if electric:  # E = grad div (z P) + k^2 z P, over k^2

            def along(p):
                up = np.array([0.0, 0.0, step])
                return (potential(*(p + up)) - potential(*(p - up))) / (2.0 * step)

            mixed = [
                (along(at + step * e) - along(at - step * e)) / (2.0 * step) for e in np.eye(3)
            ]
            exact = axis * potential(*at) + np.array(mixed) / K**2
        else:  # E = -curl (z P) / jk
            exact = np.array([gradient_z[1], -gradient_z[0], 0.0]) / (-1j * K)
        beta = np.arctan2(r0 + r1, z1)
        edge_point = np.array([0.0, 0.0, z1 * r0 / (r0 + r1)])
        source = np.array([r0 * np.cos(phi_in), r0 * np.sin(phi_in), 0.0])
        before_m, after_m = np.linalg.norm(edge_point - source), np.linalg.norm(at - edge_point)
        incoming, outgoing = (edge_point - source) / before_m, (at - edge_point) / after_m
        field = axis - incoming * np.cos(beta) if electric else -np.cross(axis, incoming)
        behind = at_edge(frame, WedgeFaces(), before_m, after_m, incoming, outgoing, field)
        length = before_m + after_m
        behind = behind * np.exp(-1j * K * length) / np.sqrt(before_m * after_m * length)
        assert np.linalg.norm(behind - exact) < 0.02 * np.linalg.norm(exact)


wedge_numbers = st.floats(0.34, 2.0)
angles = st.floats(0.02, 0.98)
skews = st.floats(0.35, np.pi - 0.35)
eps = st.sampled_from(MATERIALS)
widths = st.sampled_from([np.inf, 0.1, 0.8])


def assert_reciprocal(n, a, b, beta, faces, rng):
    frame, axis = make_frame(n, rng)
    into = ray(frame, axis, a * n * np.pi, beta, outward=False)
    out = ray(frame, axis, b * n * np.pi, beta, outward=True)
    p, q = np.cross(into, rng.normal(size=3)), np.cross(out, rng.normal(size=3))
    there = q @ at_edge(frame, faces, 2.0, 3.0, into, out, p)
    back = p @ at_edge(frame, faces, 3.0, 2.0, -out, -into, q)
    assert there == pytest.approx(back, abs=1e-9)


@given(wedge_numbers, angles, angles, skews, eps, eps, widths, widths, st.booleans(), st.randoms())
def test_the_dyad_is_reciprocal(n, a, b, beta, eps_0, eps_n, w0, wn, transparent, random):
    rng = np.random.default_rng(random.randrange(2**32))
    assert_reciprocal(n, a, b, beta, WedgeFaces((eps_0, eps_n), (w0, wn), transparent), rng)


@pytest.mark.parametrize("eps_n", MATERIALS)
@pytest.mark.parametrize("m", [2, 3, 4])
def test_back_along_the_bisector_of_a_corner_both_orders_of_its_faces_are_one_way(m, eps_n):
    faces = WedgeFaces((MATERIALS[1], eps_n), (np.inf, 0.1), transparent=False)
    assert_reciprocal(1.0 / m, 0.5, 0.5, 1.0, faces, np.random.default_rng(m))


def mirrored_field(field, direction, normal, permittivity, thickness):
    """Field and direction after one reflection, from the TE and TM coefficients."""
    cosine = -direction @ normal
    if np.isinf(thickness):
        te, tm = half_space(complex(permittivity), abs(cosine))
    else:
        te, tm, _, _ = slab(complex(permittivity), abs(cosine), thickness)
    out = direction + 2.0 * cosine * normal
    across = np.cross(direction, normal)
    across /= np.linalg.norm(across)
    e_te, e_tm = field @ across, field @ np.cross(across, direction)
    return te * e_te * across + tm * e_tm * np.cross(across, out), out


def let_through(field, direction, normal, permittivity, thickness):
    cosine = abs(direction @ normal)
    _, _, te, tm = slab(complex(permittivity), cosine, thickness)
    across = np.cross(direction, normal)
    across /= np.linalg.norm(across)
    parallel = np.cross(across, direction)
    air = np.exp(2j * np.pi * thickness * cosine)
    return air * (te * (field @ across) * across + tm * (field @ parallel) * parallel)


def image_field(frame, faces, mirrored, number, incoming, field):
    """Field of an image, and the direction in which it travels, by one reflection after another."""
    n = frame[0, 6]
    t0, n0 = frame[0, :3], frame[0, 3:6]
    end_normal = -(np.cos(n * np.pi) * n0 - np.sin(n * np.pi) * t0)
    count = abs(2 * number - 1) if mirrored else abs(2 * number)
    # Counted upwards the face next to the receiver is n, downwards it is 0.
    last = 1 if number > 0 else 0
    direction = incoming
    for i in range(count - 1, -1, -1):
        face = (last + i) % 2
        field, direction = mirrored_field(
            field,
            direction,
            n0 if face == 0 else end_normal,
            faces.permittivity[face],
            faces.thickness_wavelengths[face],
        )
    return field, direction


def boundaries(n, phi_in):
    """Every boundary inside the air: (mirrored, number, sign, phi)."""
    for mirrored in (False, True):
        for number in range(-4, 5):
            image = 2.0 * n * np.pi * number + (-phi_in if mirrored else phi_in)
            for sign in (1.0, -1.0):
                phi = image - sign * np.pi
                if 0.02 < phi < n * np.pi - 0.02:
                    yield mirrored, number, sign, phi


@given(wedge_numbers, angles, skews, eps, eps, widths, widths, st.booleans(), st.randoms())
def test_total_field_is_continuous_across_every_boundary(
    n, a, beta, eps_0, eps_n, w0, wn, transparent, random
):
    rng = np.random.default_rng(random.randrange(2**32))
    if random.random() < 0.3 or n > 2.0 - 1e-9:  # from there on a wedge counts as a sheet
        n = 2.0
    # Of a wedge pi / m two boundaries coincide, and the images lose nothing there.
    assume(abs(1.0 / n - round(1.0 / n)) > 1e-3)
    if n == 2.0:
        eps_n, wn = eps_0, w0
    frame, axis = make_frame(n, rng)
    faces = WedgeFaces((eps_0, eps_n), (w0, wn), transparent)
    phi_in = a * n * np.pi
    incoming = ray(frame, axis, phi_in, beta, outward=False)
    before_m, after_m = random.uniform(0.5, 20.0), random.uniform(0.5, 20.0)
    field = np.cross(incoming, rng.normal(size=3) + 1j * rng.normal(size=3))
    for mirrored, number, sign, phi in boundaries(n, phi_in):
        step = 1e-7
        lit, dark = (
            at_edge(
                frame,
                faces,
                before_m,
                after_m,
                incoming,
                ray(frame, axis, phi + sign * side * step, beta, outward=True),
                field,
            )
            for side in (1.0, -1.0)
        )
        jump = (lit - dark) * np.sqrt((before_m + after_m) / (before_m * after_m))
        image, direction = image_field(frame, faces, mirrored, number, incoming, field)
        assert direction == pytest.approx(ray(frame, axis, phi, beta, outward=True), abs=1e-9)
        opaque = np.isinf([w0, wn]).any() or CONDUCTOR in (eps_0, eps_n)
        if not mirrored and number == 0 and transparent and not opaque:
            t0, n0 = frame[0, :3], frame[0, 3:6]
            end_normal = np.cos(n * np.pi) * n0 - np.sin(n * np.pi) * t0
            sheets = [(n0, eps_0, w0)] + ([(end_normal, eps_n, wn)] if n < 2.0 else [])
            through = image
            for sheet in sheets if sign < 0.0 else sheets[::-1]:
                through = let_through(through, incoming, *sheet)
            image = image - through
        assert np.linalg.norm(jump + image) < 1e-4 * np.linalg.norm(field)


@given(
    st.floats(1.3, 2.0),
    st.floats(0.05, 0.4),
    st.floats(0.02, 0.98),
    st.sampled_from(MATERIALS[1:]),
    st.floats(0.5, 50.0),
)
def test_behind_a_lossy_wedge_little_more_than_half_of_the_wave_arrives(
    n, a, b, permittivity, after_m
):
    """No gain: half on the shadow boundary, and what the other boundaries add within 0.5 m."""
    phi_in = a * (n - 1.0) * np.pi
    phi = phi_in + np.pi + b * ((n - 1.0) * np.pi - phi_in)
    d = wedge_coefficients(
        phi_in,
        phi,
        air_angle_rad=n * np.pi,
        wavenumber_rad_per_m=K,
        before_m=np.inf,
        after_m=after_m,
        faces=WedgeFaces((permittivity, permittivity)),
    )
    assert np.linalg.norm(d, 2) < 0.6 * np.sqrt(after_m)


@pytest.mark.parametrize("mirrored", [False, True])
@given(angles, skews, eps, widths, st.randoms())
def test_exactly_on_a_boundary_the_source_is_hidden_and_a_reflection_there(
    mirrored, a, beta, eps_0, w0, random
):
    rng = np.random.default_rng(random.randrange(2**32))
    frame, axis = make_frame(1.5, rng)
    faces = WedgeFaces((eps_0, eps_0), (w0, w0))
    phi_in = 0.5 * a * np.pi
    phi, inside = (np.pi - phi_in, -1e-8) if mirrored else (np.pi + phi_in, 1e-8)
    incoming = ray(frame, axis, phi_in, beta, outward=False)
    field = np.cross(incoming, rng.normal(size=3))
    exactly, beside = (
        at_edge(
            frame,
            faces,
            2.0,
            3.0,
            incoming,
            ray(frame, axis, phi + off, beta, outward=True),
            field,
            tolerance_m=1e-9,
        )
        for off in (0.0, inside)
    )
    assert exactly == pytest.approx(beside, abs=1e-6 * np.linalg.norm(field))


@given(st.floats(0.5, 10.0), st.floats(0.5, 10.0), st.floats(0.1, 0.9), skews, st.booleans())
def test_a_reflection_is_there_up_to_the_tolerance_from_the_rim_and_no_further(
    before, after, a, beta, last
):
    """The reflection point is the line's from the receiver to the image, as paths are searched."""
    frame, axis = make_frame(1.5, np.random.default_rng(0))
    tolerance_m, field = 1e-5, np.array([0.3, 0.5, 0.7])
    phi_in = a * np.pi
    rho_in, rho_out = before * np.sin(beta), after * np.sin(beta)

    def behind(place_m):
        # From the place beyond the rim along the unfolded ray to the receiver's azimuth.
        x = place_m * (rho_in + rho_out) * np.sin(phi_in) / (rho_in * rho_out)
        turn = np.pi - phi_in - x
        out = 1.5 * np.pi - turn if last else turn
        outgoing = ray(frame, axis, out, beta, outward=True)
        return at_edge(
            frame, WedgeFaces(), before, after, incoming, outgoing, field, tolerance_m=tolerance_m
        )

    into = 1.5 * np.pi - phi_in if last else phi_in
    incoming = ray(frame, axis, into, beta, outward=False)
    image = np.linalg.norm(np.cross(field, incoming)) * np.sqrt(before * after / (before + after))
    lit = [behind(place * tolerance_m) for place in (1.0, 0.0, -0.999)]
    assert np.linalg.norm(lit[0] - lit[1]) < 0.01 * image
    assert np.linalg.norm(lit[2] - lit[1]) < 0.01 * image
    dark = behind(-1.001 * tolerance_m)
    assert np.linalg.norm(dark - lit[1]) == pytest.approx(image, rel=0.01)


def test_layers_of_one_material_are_one_face():
    whole = WedgeFaces((4.0 - 0.1j, 5.0 - 0.2j), (0.3, 0.4), transparent=True)
    split = WedgeFaces(
        ((4.0 - 0.1j,) * 2, (5.0 - 0.2j,) * 3), ((0.1, 0.2), (0.1, 0.1, 0.2)), transparent=True
    )
    assert coefficients(split) == pytest.approx(coefficients(whole), abs=1e-12)


def test_the_layer_in_the_air_comes_first():
    """A thin coat on a conductor is the coat; a conductor before anything is a conductor."""
    conductor = coefficients(WedgeFaces())
    before = WedgeFaces(((CONDUCTOR, 4.0), CONDUCTOR), ((np.inf, 0.2), np.inf))
    behind = WedgeFaces(((4.0, CONDUCTOR), CONDUCTOR), ((0.2, np.inf), np.inf))
    assert np.array_equal(coefficients(before), conductor)
    assert np.abs(coefficients(behind) - conductor).max() > 0.01


def coefficients(faces):
    angles = np.linspace(0.1, 1.4 * np.pi, 7)
    return wedge_coefficients(
        angles[:, None],
        angles[None, :] + 0.01,
        air_angle_rad=1.5 * np.pi,
        wavenumber_rad_per_m=K,
        before_m=3.0,
        after_m=2.0,
        skew_rad=1.1,
        faces=faces,
    )


@given(wedge_numbers, st.floats(0.0, 1.0), st.floats(0.0, 1.0), skews, eps, eps, widths)
def test_any_wedge_at_any_distance_is_finite(n, a, b, beta, eps_0, eps_n, width):
    d = wedge_coefficients(
        a * n * np.pi,
        b * n * np.pi,
        air_angle_rad=n * np.pi,
        wavenumber_rad_per_m=K,
        before_m=[1e-6, 0.01, 1e6, np.inf],
        after_m=[1e-6, 3.0, 1e6, 1.0],
        skew_rad=beta,
        faces=WedgeFaces((eps_0, eps_n), (width, np.inf), transparent=True),
    )
    assert np.isfinite(d).all()


@pytest.mark.parametrize("i", [0, 1])
def test_a_lossy_face_shorts_what_grazes_it(i):
    """Fresnel's coefficients are -1 at grazing, so nothing travels along a lossy face."""
    d = wedge_coefficients(
        np.pi / 4.0,
        1.5 * np.pi,
        air_angle_rad=1.5 * np.pi,
        wavenumber_rad_per_m=K,
        before_m=9.0,
        after_m=7.0,
        faces=WedgeFaces((5.24 - 0.33j, 5.24 - 0.33j)),
    )
    assert abs(d[i, i]) < 1e-4


def test_a_ray_along_the_edge_brings_nothing():
    frame, axis = make_frame(1.5, np.random.default_rng(1))
    e = at_edge(frame, WedgeFaces(), 1.0, 1.0, axis, axis, frame[0, :3])
    assert not e.any()


@pytest.mark.parametrize(
    "wrong",
    [
        {"air_angle_rad": 7.0},
        {"skew_rad": 0.0},
        {"before_m": -1.0},
        {"wavenumber_rad_per_m": 0.0},
        {"incidence_rad": 4.0, "air_angle_rad": 3.5},
    ],
)
def test_impossible_wedges_are_refused(wrong):
    right = {
        "incidence_rad": 1.0,
        "observation_rad": 2.0,
        "air_angle_rad": 4.0,
        "wavenumber_rad_per_m": K,
        "before_m": 1.0,
        "after_m": 1.0,
    }
    with pytest.raises(GeometryError):
        wedge_coefficients(**(right | wrong))


def test_transition_function_refuses_negative_arguments():
    with pytest.raises(GeometryError, match="x = -1"):
        transition_function(-1.0)
