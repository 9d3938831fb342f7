"""A half-wave dipole's files, written by hand in every format, from textbook formulas alone."""

import numpy as np

F_HZ = 2.4e9
C = 299792458.0
ETA = 376.730313668
DIPOLE_DBI = 2.151  # Balanis, Antenna Theory: directivity 1.643 of the half-wave dipole


def dipole_e(theta_deg, phi_deg, power_w=1.0):
    """r E_theta [V peak] of a vertical half-wave dipole radiating a power: Balanis 4-84, 4-88."""
    theta = np.radians(theta_deg)
    st = np.sin(theta)
    shape = np.where(st > 1e-9, np.cos(0.5 * np.pi * np.cos(theta)) / np.where(st > 1e-9, st, 1), 0)
    # P = eta |I0|^2 Cin(2 pi) / (8 pi), rE = j eta I0 shape / (2 pi)
    current = np.sqrt(power_w * 8 * np.pi / (ETA * 2.4376534))
    return 1j * ETA * current / (2 * np.pi) * shape * np.ones_like(phi_deg)


def degrees(step_theta=5.0, step_phi=10.0):
    theta = np.linspace(0.0, 180.0, round(180 / step_theta) + 1)
    phi = np.linspace(0.0, 360.0, round(360 / step_phi) + 1)
    return theta, phi


def dbi(e_v, power_w=1.0):
    return 10 * np.log10(np.maximum(2 * np.pi * np.abs(e_v) ** 2 / (ETA * power_w), 1e-30))


def ffe_text(power_w=0.01, result="Gain"):
    theta, phi = degrees()
    heads = '"Theta" "Phi" "Re(Etheta)" "Im(Etheta)" "Re(Ephi)" "Im(Ephi)"'
    lines = [
        "##File Type: Far field",
        "##File Format: 8",
        "##Source: dipole",
        "** File exported by hand",
        "",
        "#Configuration Name: StandardConfiguration1",
        "#Request Name: FarField1",
        f"#Frequency:   {F_HZ:.8E}",
        "#Coordinate System: Spherical",
        f"#No. of Theta Samples: {len(theta)}",
        f"#No. of Phi Samples: {len(phi)}",
        f"#Result Type: {result}",
        "#No. of Header Lines: 1",
        f'# {heads} "{result}(Theta)" "{result}(Phi)" "{result}(Total)"',
    ]
    for p in phi:
        for t in theta:
            e = dipole_e(t, p, power_w)
            g = dbi(e, power_w)
            lines.append(
                f"  {t:.8E}  {p:.8E}  {e.real:.8E}  {e.imag:.8E}  0.0  0.0  "
                f"{g:.8E}  -1.0E+03 {g:.8E}"
            )
    return "\n".join(lines) + "\n"


def ffd_text(power_w=1.0):
    theta, phi = degrees()
    lines = [f"0 180 {len(theta)}", f"0 360 {len(phi)}", "Frequencies 1", f"Frequency {F_HZ:.1f}"]
    for t in theta:
        for p in phi:
            e = dipole_e(t, p, power_w)
            lines.append(f"{e.real:.9e} {e.imag:.9e} 0.0 0.0")
    return "\n".join(lines) + "\n"


def ffs_text(power_w=0.5, powers=(0.5, 0.5, 0.5)):
    theta, phi = degrees()
    lines = [
        *("// CST Farfield Source File", "", "// Version:", "3.0", "", "// Data Type", "Farfield"),
        *("", "// #Frequencies", "1", "", "// Position", "0.0e+00 0.0e+00 0.0e+00", ""),
        *("// zAxis", "0.0e+00 0.0e+00 1.0e+00", "", "// xAxis", "1.0e+00 0.0e+00 0.0e+00", ""),
        "// Radiated/Accepted/Stimulated Power , Frequency",
        *(f"{p:.6e}" for p in powers),
        *(f"{F_HZ:.6e}", "", "// >> Total #phi samples, total #theta samples"),
        f"{len(phi)} {len(theta)}",
        "",
        "// >> Phi, Theta, Re(E_Theta), Im(E_Theta), Re(E_Phi), Im(E_Phi):",
    ]
    for p in phi:
        for t in theta:
            e = dipole_e(t, p, power_w)
            lines.append(f"{p:8.3f} {t:8.3f}  {e.real:.8e} {e.imag:.8e} 0.0e+000 0.0e+000")
    return "\n".join(lines) + "\n"


def nec_text(power_w=0.0068, range_m=0.0, zin=(73.1, 42.5), budget=True):
    theta, phi = degrees()
    lines = [
        "                         --------- FREQUENCY --------",
        f"                                FREQUENCY : {F_HZ / 1e6:.4E} MHz",
        f"                                WAVELENGTH: {C / F_HZ:.4E} METERS",
        "",
        "                        --------- ANTENNA INPUT PARAMETERS ---------",
        "  TAG   SEG       VOLTAGE (VOLTS)         CURRENT (AMPS)         IMPEDANCE (OHMS)",
        "  NO.   NO.     REAL      IMAGINARY     REAL      IMAGINARY     REAL      IMAGINARY",
        f" 0  4  1E+00  0E+00  1.0E-02-5.9E-03  {zin[0]:.4E}{zin[1]:+.4E}  1E-02-5E-03  6.8E-03",
        "",
    ]
    if budget:
        lines += [
            "                               ---------- POWER BUDGET ---------",
            f"                               INPUT POWER   =  {power_w:.6E} Watts",
            f"                               RADIATED POWER=  {power_w:.6E} Watts",
            "                               EFFICIENCY    =   100.00 Percent",
            "",
        ]
    lines += ["                             ---------- RADIATION PATTERNS -----------", ""]
    spread = 1.0
    if range_m:
        wavelengths = range_m * F_HZ / C
        turn_deg = -360.0 * (wavelengths - np.floor(wavelengths))
        spread = np.exp(1j * np.radians(turn_deg)) / range_m
        lines += [
            f"                             RANGE: {range_m:13.6E} METERS",
            f"               EXP(-JKR)/R: {1 / range_m:.9E} AT PHASE: {turn_deg:.6f} DEGREES",
            "",
        ]
    lines += [
        " ---- ANGLES -----     ----- POWER GAINS -----       ---- POLARIZATION ----",
        "  THETA      PHI        MAJOR    MINOR   TOTAL       AXIAL      TILT  SENSE   MAGNITUDE",
        " DEGREES   DEGREES        DB       DB       DB       RATIO   DEGREES            VOLTS/M",
    ]
    for p in phi:
        for t in theta:
            e = dipole_e(t, p, power_w) * spread
            g = max(float(dbi(e / spread, power_w)), -999.99)
            sense = "LINEAR" if abs(e) > 1e-8 else "      "
            lines.append(
                f" {t:7.2f} {p:9.2f}   {g:8.2f} {-999.99:8.2f} {g:8.2f} {0.0:11.4f} {0.0:9.2f} "
                f"{sense} {abs(e):11.6E} {np.degrees(np.angle(e)):9.2f} {0.0:11.4E} {0.0:9.2f}"
            )
    return "\n".join([*lines, "", "", " RUN TIME =      0.010", ""])


def msi_text(gain="2.15 dBi", polarization="VERTICAL"):
    loss = [DIPOLE_DBI - float(dbi(dipole_e(abs(90.0 - a), 0.0))) for a in range(-90, 90)]
    down = [min(max(x, 0.0), 80.0) for x in loss]  # elevations -90 .. 89
    by_angle = {a: down[90 - a] if -90 < a <= 90 else 80.0 for a in range(-90, 91)}
    lines = [
        *("NAME half-wave dipole", "MAKE by hand", "FREQUENCY 2400", "H_WIDTH 360"),
        *("V_WIDTH 78", "FRONT_TO_BACK 0", f"GAIN {gain}", "TILT 0"),
        *(f"POLARIZATION {polarization}", "COMMENT none", "HORIZONTAL 360"),
    ]
    lines += [f"{a}.0 0.0" for a in range(360)]
    lines.append("VERTICAL 360")
    for a in range(360):
        fold = a if a <= 90 else (180 - a if a <= 270 else a - 360)
        lines.append(f"{a}.0 {by_angle[fold]:.6f}")
    return "\n".join(lines) + "\n"


def csv_text():
    theta, phi = degrees()
    lines = ["# a dipole", "theta_deg, phi_deg, f_theta_re, f_theta_im, f_phi_re, f_phi_im, kind"]
    for t in theta:
        for p in phi:
            f = dipole_e(t, p) / np.sqrt(ETA / (2 * np.pi))
            lines.append(f"{t},{p},{f.real:.12e},{f.imag:.12e},0,0,realised_gain")
    return "\n".join(lines) + "\n"


TEXTS = {
    "ffe": ffe_text,
    "ffd": ffd_text,
    "ffs": ffs_text,
    "nec": nec_text,
    "msi": msi_text,
    "csv": csv_text,
}
