from .compatibility import check_continues as check_continues
