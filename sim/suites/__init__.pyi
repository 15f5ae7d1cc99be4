from .catalogue import SUITES as SUITES
from .laws import LAWS as LAWS
from .pytest_items import slam_checks as slam_checks
from .report import SuiteReport as SuiteReport
from .report import check_slam as check_slam
from .suite import Suite as Suite
from .suite import SuitePart as SuitePart
