"""The pressures among the contact problems as a test set of qpbenchmark.

qpbenchmark rolling_contact.py run
"""

import contact_problems
import qpbenchmark


class RollingContact(qpbenchmark.TestSet):
    """Pressures of contact problems: dense, strictly convex, degenerate at the contact edge."""

    @property
    def title(self):
        return "Rolling contact test set"

    @property
    def description(self):
        return "Pressures between elastic bodies (Kalker's normal problem), by varcontact."

    @property
    def sparse_only(self):
        return False

    def __iter__(self):
        for name in contact_problems.names("normal"):
            problem = contact_problems.load(name)
            if problem["symmetric"]:
                data = contact_problems.quadratic_program(problem)
                yield qpbenchmark.Problem(*data, name=name)
