from dataclasses import replace

import h5py
import numba
import numpy as np
import pytest
import scipy.sparse as sp

from risorius.carried_basis import ROUNDED_OFF, CarriedBasis
from risorius.errors import InputError
from risorius.reconstruction import CarriedReconstruction, PlainReconstruction, reconstruction
from risorius.vector_lanes import LANES
from risorius.vector_sums import least_squared, whole_blocks
from risorius.whole_steps import rounded_fields

RANK, CARRIERS = 30, 40


def made_up(count: int) -> tuple[CarriedBasis, np.ndarray]:
    """Basis of `count` vertices, each carried by up to seven of CARRIERS points, one by none, and their rest shape."""
    rng = np.random.default_rng(3)
    columns = rng.integers(0, CARRIERS, (count, 7))
    shares = rng.uniform(-0.1, 1.0, (count, 7))
    shares[count // 2] = 0.0
    weights = sp.csr_matrix(
        (shares.ravel(), (np.repeat(np.arange(count), 7), columns.ravel())), shape=(count, CARRIERS)
    )
    weights.eliminate_zeros()
    fields = rng.normal(size=(RANK, CARRIERS, 3)).astype(np.float32) * 1e-3
    return CarriedBasis(fields, weights), rng.uniform(-0.1, 0.1, (count, 3)).astype(np.float32)


def exact(basis, rest, coordinates):
    return rest + basis.weights @ np.tensordot(coordinates, basis.fields.astype(np.float64), axes=1)


def written(way, coordinates, count):
    out = np.full((count, 3), np.nan, dtype=np.float32)
    way.write(coordinates, out)
    return out


@pytest.fixture(params=[CarriedReconstruction, PlainReconstruction])
def way(request):
    return request.param


@pytest.mark.parametrize("count", [1, 16, 500])  # less than a block, a whole one, and some with a part of one
@pytest.mark.parametrize("size", [1.0, 1e4])
def test_vertices_are_the_exact_sum_within_the_stated_error(way, count, size):
    basis, rest = made_up(count)
    coordinates = size * np.random.default_rng(5).normal(size=RANK)
    built = way(basis, rest)
    error = np.abs(written(built, coordinates, count) - exact(basis, rest, coordinates)).max()
    assert error <= built.error_bound(coordinates) < 1e-5 * size


def test_stated_error_is_that_of_single_precision_and_grows_with_the_coordinates(way):
    basis, rest = made_up(500)
    built = way(basis, rest)
    at_rest, little, much = (built.error_bound(np.full(RANK, size)) for size in (0.0, 1.0, 1e3))
    assert at_rest == pytest.approx(np.abs(rest).max() * 2.0**-24)
    assert much - at_rest == pytest.approx(1e3 * (little - at_rest))


def test_zero_coordinates_give_the_rest_shape_to_the_last_bit(way):
    basis, rest = made_up(500)
    np.testing.assert_array_equal(written(way(basis, rest), np.zeros(RANK), 500), rest)


def test_rounded_fields_take_half_the_bytes_and_give_the_same_sums(way):
    basis, rest = made_up(500)
    rounded = CarriedBasis(rounded_fields(basis.fields), sp.identity(CARRIERS, format="csr"))
    ours = way(rounded, rest[:CARRIERS])
    coordinates = np.random.default_rng(5).normal(size=RANK)
    error = np.abs(written(ours, coordinates, CARRIERS) - exact(rounded, rest[:CARRIERS], coordinates)).max()
    assert error <= ours.error_bound(coordinates)
    single = way(CarriedBasis(basis.fields, rounded.weights), rest[:CARRIERS])
    assert single.bytes_read - ours.bytes_read == RANK * 2 * whole_blocks(3 * CARRIERS)


def test_fields_are_rounded_by_less_than_one_of_32767_parts_and_their_parts_not_again():
    fields = made_up(500)[0].fields
    rounded = rounded_fields(fields)
    assert (np.abs(rounded - fields).max(axis=(1, 2)) <= np.abs(fields).max(axis=(1, 2)) / 32767).all()
    np.testing.assert_array_equal(rounded_fields(rounded[:, :9]), rounded[:, :9])


SIZES = np.geomspace(1.0, 1e-4, RANK)


@pytest.fixture
def coarse():
    """Basis whose last fields are coarse, and what it was before."""
    basis, _ = made_up(500)
    basis = CarriedBasis(rounded_fields(basis.fields), basis.weights)
    return basis.rounded_off(SIZES), basis


def test_coarse_fields_are_as_many_as_leave_out_what_they_may(coarse):
    basis, before = coarse
    missed = 3.0 * SIZES**2 * np.square(rounded_fields(before.fields, np.int8) - before.fields).mean(axis=(1, 2))
    first = int(np.flatnonzero(basis.coarse)[0])
    assert 0 < first < RANK - 3 and basis.coarse[first:].all()
    assert missed[first:].sum() <= ROUNDED_OFF**2 < missed[first - 1 :].sum()
    coordinates = SIZES * np.random.default_rng(0).normal(size=(2000, RANK))
    apart = np.tensordot(coordinates, basis.fields.astype(np.float64) - before.fields, axes=1)
    assert np.sqrt((apart**2).sum(axis=2).mean()) == pytest.approx(np.sqrt(missed[first:].sum()), rel=0.05)


@pytest.mark.parametrize("size", [1.0, 1e4])
def test_sums_of_coarse_fields_are_exact_within_the_stated_error(way, coarse, size):
    weights = sp.identity(CARRIERS, format="csr") if way is PlainReconstruction else coarse[0].weights
    basis, count = replace(coarse[0], weights=weights), weights.shape[0]
    rest = made_up(count)[1]
    built = way(basis, rest)
    for coordinates in size * SIZES * np.random.default_rng(5).normal(size=(50, RANK)):
        error = np.abs(written(built, coordinates, count) - exact(basis, rest, coordinates)).max()
        assert error <= built.error_bound(coordinates) < 2e-5 * size


def test_coarse_fields_take_one_byte_a_number(coarse):
    """Pairs of them: of an odd number one more."""
    basis, before = coarse
    count, rest = int(basis.coarse.sum()), made_up(500)[1]
    saved = CarriedReconstruction(before, rest).bytes_read - CarriedReconstruction(basis, rest).bytes_read
    assert saved == (2 * count - (count + count % 2)) * whole_blocks(3 * CARRIERS)


def test_parts_of_a_basis_and_its_file_know_which_fields_are_coarse(coarse, tmp_path):
    basis, _ = coarse
    with h5py.File(tmp_path / "basis.h5", "w") as file:
        basis.write(file.create_group("basis"))
        stored = CarriedBasis.read(file["basis"])
    np.testing.assert_array_equal(stored.fields, basis.fields)
    np.testing.assert_array_equal(stored.coarse, basis.coarse)
    np.testing.assert_array_equal(basis.leading(20).coarse, basis.coarse[:20])
    followed = basis.followed_by([np.ones((2, CARRIERS, 3), np.float32)])
    np.testing.assert_array_equal(followed.coarse, [*basis.coarse, False, False])
    assert basis.in_axes((2, 0, 1)).coarse is basis.coarse


def test_a_vertex_that_nothing_carries_stays(way):
    basis, rest = made_up(1)
    np.testing.assert_array_equal(written(way(basis, rest), np.ones(RANK), 1), rest)


def test_a_refined_surface_is_carried_and_nodes_themselves_are_not():
    basis, rest = made_up(500)
    assert isinstance(reconstruction(basis, rest), CarriedReconstruction)
    assert isinstance(reconstruction(CarriedBasis.of_vertices(basis.at_vertices()), rest), PlainReconstruction)


def test_fields_of_other_carriers_are_refused():
    with pytest.raises(InputError, match=r"basis: fields \(5, 3, 3\) .* weights \(9, 4\); give fields \(r, 4, 3\)"):
        CarriedBasis(np.zeros((5, 3, 3), np.float32), sp.csr_matrix((9, 4)))


def test_least_squared_distance_is_that_of_single_numbers_to_the_last_bit():
    @numba.njit
    def least(places, start, own):
        return least_squared(places[0], places[1], places[2], start, own[0], own[1], own[2])

    rng = np.random.default_rng(0)
    places, own = (rng.normal(size=shape).astype(np.float32) for shape in ((3, 4 * LANES), 3))
    squares = (places - own[:, None]) ** 2
    expected = squares[0] + squares[1] + squares[2]
    for start in range(3 * LANES):
        assert least(places, start, own) == expected[start : start + LANES].min()
