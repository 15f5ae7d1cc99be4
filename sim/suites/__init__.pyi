from .catalogue import SUITES as SUITES
from .laws import LAWS as LAWS
from .report import SuiteReport as SuiteReport
from .report import check_slam as check_slam
from .slam_checks import slam_checks as slam_checks
from .suite import Part as Part
from .suite import Suite as Suite
