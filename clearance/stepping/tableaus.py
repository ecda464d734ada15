"""Coefficients of the steppers.

DOP853: the explicit pair of order 8(5,3) of Dormand and Prince with dense output of order 7, twelve
stages and three more for the dense output. Source: Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I (1993), II.10, code dop853. RADAU5, RADAU9: Radau IIA with three and five
stages, order 5 and 9, in the real and complex eigenbasis of the inverse matrix. Source: Hairer and
Wanner, Solving Ordinary Differential Equations II (1996), IV.5 and IV.8, and "Stiff differential
equations solved by Radau methods", J. Comput. Appl. Math. 111 (1999). The nodes are zeros of a
Legendre combination, everything else follows from them.
"""

from typing import NamedTuple

import numpy as np

# nodes, stage matrix (row 12 holds the weights), error weights (orders 5 and 3), dense output
# weights

C = np.array(
    (
        0.0,
        0.05260015195876773,
        0.0789002279381516,
        0.1183503419072274,
        0.2816496580927726,
        0.3333333333333333,
        0.25,
        0.3076923076923077,
        0.6512820512820513,
        0.6,
        0.8571428571428571,
        1.0,
        1.0,
        0.1,
        0.2,
        0.7777777777777778,
    )
)
_ROWS = (
    (),
    (0.05260015195876773,),
    (0.0197250569845379, 0.0591751709536137),
    (0.02958758547680685, 0.0, 0.08876275643042054),
    (0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792),
    (0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242),
    (0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125),
    (
        0.03709200011850479,
        0.0,
        0.0,
        0.17038392571223998,
        0.10726203044637328,
        -0.015319437748624402,
        0.008273789163814023,
    ),
    (
        0.6241109587160757,
        0.0,
        0.0,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
    ),
    (
        0.47766253643826434,
        0.0,
        0.0,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
    ),
    (
        -0.9371424300859873,
        0.0,
        0.0,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
    ),
    (
        2.273310147516538,
        0.0,
        0.0,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
    ),
    (
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ),
    (
        0.056167502283047954,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.25350021021662483,
        -0.2462390374708025,
        -0.12419142326381637,
        0.15329179827876568,
        0.00820105229563469,
        0.007567897660545699,
        -0.008298,
    ),
    (
        0.03183464816350214,
        0.0,
        0.0,
        0.0,
        0.0,
        0.028300909672366776,
        0.053541988307438566,
        -0.05492374857139099,
        0.0,
        0.0,
        -0.00010834732869724932,
        0.0003825710908356584,
        -0.00034046500868740456,
        0.1413124436746325,
    ),
    (
        -0.42889630158379194,
        0.0,
        0.0,
        0.0,
        0.0,
        -4.697621415361164,
        7.683421196062599,
        4.06898981839711,
        0.3567271874552811,
        0.0,
        0.0,
        0.0,
        -0.0013990241651590145,
        2.9475147891527724,
        -9.15095847217987,
    ),
)
B = np.array(_ROWS[12])
E5 = np.array(
    (
        0.01312004499419488,
        0.0,
        0.0,
        0.0,
        0.0,
        -1.2251564463762044,
        -0.4957589496572502,
        1.6643771824549864,
        -0.35032884874997366,
        0.3341791187130175,
        0.08192320648511571,
        -0.022355307863886294,
        0.0,
    )
)
E3 = np.append(B, 0.0)  # less the weights of order 3
E3[[0, 8, 11]] -= 0.2440944881889764, 0.7338466882816118, 0.022058823529411766
D = np.array(
    (
        (
            -8.428938276109013,
            0.0,
            0.0,
            0.0,
            0.0,
            0.5667149535193777,
            -3.0689499459498917,
            2.38466765651207,
            2.117034582445028,
            -0.871391583777973,
            2.2404374302607883,
            0.6315787787694688,
            -0.08899033645133331,
            18.148505520854727,
            -9.194632392478356,
            -4.436036387594894,
        ),
        (
            10.427508642579134,
            0.0,
            0.0,
            0.0,
            0.0,
            242.28349177525817,
            165.20045171727028,
            -374.5467547226902,
            -22.113666853125306,
            7.733432668472264,
            -30.674084731089398,
            -9.332130526430229,
            15.697238121770845,
            -31.139403219565178,
            -9.35292435884448,
            35.81684148639408,
        ),
        (
            19.985053242002433,
            0.0,
            0.0,
            0.0,
            0.0,
            -387.0373087493518,
            -189.17813819516758,
            527.8081592054236,
            -11.57390253995963,
            6.8812326946963,
            -1.0006050966910838,
            0.7777137798053443,
            -2.778205752353508,
            -60.19669523126412,
            84.32040550667716,
            11.99229113618279,
        ),
        (
            -25.69393346270375,
            0.0,
            0.0,
            0.0,
            0.0,
            -154.18974869023643,
            -231.5293791760455,
            357.6391179106141,
            93.40532418362432,
            -37.45832313645163,
            104.0996495089623,
            29.8402934266605,
            -43.53345659001114,
            96.32455395918828,
            -39.17726167561544,
            -149.72683625798564,
        ),
    )
)

A = np.array([[*row, *[0.0] * (16 - len(row))] for row in _ROWS])


class Collocation(NamedTuple):
    """Radau IIA with c.size stages in the eigenbasis of its inverse matrix.

    c, a: nodes and stage matrix; real, pairs: eigenvalues of inv(a), the real one and one of each
    complex pair; t, ti: stages = t transformed, transformed = ti stages, ordered (real, then real
    and imaginary part of each pair); e: weights of the error estimate of order c.size; basis: rows
    of the nested dense output from the stages; end: h y' at the end of the step from the stages.
    """

    c: np.ndarray
    a: np.ndarray
    real: float
    pairs: np.ndarray
    t: np.ndarray
    ti: np.ndarray
    e: np.ndarray
    basis: np.ndarray
    end: np.ndarray


def nested(theta: float, rows: int) -> np.ndarray:
    """The functions of theta that the rows of a dense output are weights of, after the first (see
    types.DENSE_ROWS).
    """
    values, value = [], 1.0
    for r in range(1, rows + 1):
        value *= theta if r % 2 == 1 else 1.0 - theta
        values.append(value)
    return np.array(values)


def radau(interior: tuple[float, ...]) -> Collocation:
    """The method with these nodes and 1."""
    c = np.array([*interior, 1.0])
    s = c.size
    points, weights = np.polynomial.legendre.leggauss(s)
    a = np.zeros((s, s))
    for i, j in np.ndindex(s, s):  # integral of the j-th Lagrange polynomial from 0 to c[i]
        x = 0.5 * c[i] * (points + 1.0)
        others = np.delete(c, j)
        a[i, j] = 0.5 * c[i] * weights @ np.prod((x[:, None] - others) / (c[j] - others), axis=1)
    inverse = np.linalg.inv(a)
    values, vectors = np.linalg.eig(inverse)
    first = int(np.argmin(np.abs(values.imag)))
    pairs = [k for k in np.argsort(-values.real) if values[k].imag < 0.0 and k != first]
    real = vectors[:, first].real / vectors[-1, first].real
    columns = [vectors[:, k] / vectors[-1, k] for k in pairs]
    # the complex pair contributes 2 Re(v w) = 2 Re v Re w - 2 Im v Im w to each stage: halves go
    # into w
    t = np.column_stack([real, *(part for v in columns for part in (v.real, -v.imag))])
    powers = c ** np.arange(s)[:, None]
    wanted = 1.0 / np.arange(1, s + 1)
    wanted[0] -= 1.0 / values[first].real
    e = values[first].real * (np.linalg.solve(powers, wanted) - a[-1]) @ inverse
    basis = np.linalg.inv(np.array([nested(x, s) for x in c]))
    return Collocation(
        c,
        a,
        float(values[first].real),
        values[pairs],
        t,
        np.linalg.inv(t),
        e,
        basis,
        inverse[-1].copy(),
    )


RADAU5 = radau((0.15505102572168219018, 0.64494897427831780982))
RADAU9 = radau(
    (
        0.057104196114517682193,
        0.27684301363812382768,
        0.58359043236891682006,
        0.86024013565621944785,
    )
)

# Rodas5P: stages of the nodes, of the stages before, over the step; weights of df/dt and of the
# dense output

RODAS_GAMMA = 0.21193756319429014
RODAS_NODES = np.array(
    (
        0.0,
        0.6358126895828704,
        0.4095798393397535,
        0.9769306725060716,
        0.4288403609558664,
        1.0,
        1.0,
        1.0,
    )
)
RODAS_D = np.array(
    (
        0.21193756319429014,
        -0.42387512638858027,
        -0.3384627126235924,
        1.8046452872882734,
        2.325825639765069,
        0.0,
        0.0,
        0.0,
    )
)
_SIXTH = (
    -7.502846399306121,
    2.561846144803919,
    -11.627539656261098,
    -0.18268767659942256,
    0.030198172008377946,
)
RODAS_A = np.array(
    [
        [*row, *[0.0] * (8 - len(row))]
        for row in (
            (),
            (3.0,),
            (2.849394379747939, 0.45842242204463923),
            (-6.954028509809101, 2.489845061869568, -10.358996098473584),
            (2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641),
            _SIXTH,
            (*_SIXTH, 1.0),
            (*_SIXTH, 1.0, 1.0),
        )
    ]
)
RODAS_C = np.array(
    [
        [*row, *[0.0] * (8 - len(row))]
        for row in (
            (),
            (-14.155112264123755,),
            (-17.97296035885952, -2.859693295451294),
            (147.12150275711716, -1.41221402718213, 71.68940251302358),
            (165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306),
            (
                24.854864614690072,
                -3.0009227002832186,
                47.4931110020768,
                5.5814197821558125,
                -0.6610691825249471,
            ),
            (
                30.91273214028599,
                -3.1208243349937974,
                77.79954646070892,
                34.28646028294783,
                -19.097331116725623,
                -28.087943162872662,
            ),
            (
                37.80277123390563,
                -3.2571969029072276,
                112.26918849496327,
                66.9347231244047,
                -40.06618937091002,
                -54.66780262877968,
                -9.48861652309627,
            ),
        )
    ]
)
RODAS_H = np.array(
    (
        (
            25.948786856663858,
            -2.5579724845846235,
            10.433815404888879,
            -2.3679251022685204,
            0.524948541321073,
            1.1241088310450404,
            0.4272876194431874,
            -0.17202221070155493,
        ),
        (
            -9.91568850695171,
            -0.9689944594115154,
            3.0438037242978453,
            -24.495224566215796,
            20.176138334709044,
            15.98066361424651,
            -6.789040303419874,
            -6.710236069923372,
        ),
        (
            11.419903575922262,
            2.8879645146136994,
            72.92137995996029,
            80.12511834622643,
            -52.072871366152654,
            -59.78993625266729,
            -0.15582684282751913,
            4.883087185713722,
        ),
    )
)
