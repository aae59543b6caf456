"""What the tissue is made of, in UFL: the formulas of ../../core/effects and of the contract of `diagnose`, and some that are in neither.

F is the deformation gradient, J its determinant; stresses in kPa = mN/mm2. Moduli and numbers of effects are Constants or functions on
quadrature points, so that a form is compiled once for all cases.
"""
import ufl

GRAVITY = 9.80665e-3  # mN/mm3 for 1 g/cm3 and 1 g0


def shape_invariant(F):
    """I1bar = J^(-2/3) tr(F^T F)."""
    return ufl.det(F) ** (-2.0 / 3.0) * ufl.inner(F, F)


def neo_hookean(F, mu):
    return mu / 2 * (shape_invariant(F) - 3)


def stiffening(F, mu, b):
    """mu / (2 b) (exp(b (I1bar - 3)) - 1)."""
    return mu / (2 * b) * (ufl.exp(b * (shape_invariant(F) - 3)) - 1)


def volume(F, kappa, growth):
    """kappa / 2 (J / Jg - 1)^2: growth Jg is 1 where nothing swells."""
    return kappa / 2 * (ufl.det(F) / growth - 1) ** 2


def fibres(F, k, axis):
    """k / 2 (I4bar - 1)^2 along a unit axis."""
    stretched = F * axis
    return k / 2 * (ufl.det(F) ** (-2.0 / 3.0) * ufl.dot(stretched, stretched) - 1) ** 2


def skin(F, normal, stiffness):
    """E h / 6 (tr C + 1 / det C - 3) of the surface's own stretch C, for incompressible neo-Hookean sheets in plane stress."""
    C, H = F.T * F, ufl.inv(F).T * normal
    return stiffness / 6 * (ufl.tr(C) - ufl.dot(normal, C * normal) + 1 / (ufl.det(F) ** 2 * ufl.dot(H, H)) - 3)


def shape_stress(F):
    """Second Piola-Kirchhoff stress of the isochoric energy for a shear modulus of 1: J^(-2/3) (1 - I1/3 C^-1)."""
    C = F.T * F
    return ufl.det(F) ** (-2.0 / 3.0) * (ufl.Identity(3) - ufl.tr(C) / 3 * ufl.inv(C))


def pack(S):
    return ufl.as_vector([S[0, 0], S[1, 1], S[2, 2], S[0, 1], S[1, 2], S[0, 2]])


def unpack(s):
    return ufl.as_matrix([[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]])


def overstress(S, before, h, kept, taken):
    """h' = e^(-dt/tau) h + (1 - e^(-dt/tau)) tau/dt (S' - S)."""
    return kept * h + taken * (S - before)


def slid(S, before, h, limit):
    """A friction element: follows the stress until its size is `limit`, then slides. What is left of it is a permanent set."""
    trial = h + S - before
    size = ufl.sqrt(ufl.inner(trial, trial) + 1e-12)
    return trial * ufl.conditional(ufl.gt(size, limit), limit / size, 1.0)


def worn(F, mu, most, inverse_r, w0):
    """Ogden and Roxburgh: eta = 1 - erf((Wmax - W) / w0) / r, what is left of the isochoric stress. most: Wmax, kPa."""
    W = neo_hookean(F, mu)
    return 1 - inverse_r * ufl.erf(ufl.max_value(0.0, most - W) / w0)
